# SPDX-License-Identifier: GPL-3.0-or-later
"""Marker sets that laboratories use, and the joints of common skeletons: labels and the landmark of each."""

from .marker_set import MarkerSet


def _both_sides(pattern, names):
    """{"LKNE": "knee.L", "RKNE": "knee.R", ...} of {"KNE": "knee"}; `pattern` puts side and name together."""
    return {pattern.format(side=side, name=name): f"{place}.{side}" for side in "LR" for name, place in names.items()}


def _aliases(pattern, names):
    """As `_both_sides`, alias -> label, both with the side in front as in `pattern`."""
    return {
        pattern.format(side=side, name=alias): pattern.format(side=side, name=name)
        for side in "LR"
        for alias, name in names.items()
    }


PLUG_IN_GAIT = MarkerSet(
    "Plug-in Gait",
    {
        **_both_sides("{side}{name}", {"FHD": "head.front", "BHD": "head.back"}),
        "C7": "neck.back", "T10": "back", "CLAV": "clavicle", "STRN": "sternum", "RBAK": "back.shoulder.R",
        **_both_sides("{side}{name}", {
            "SHO": "shoulder", "UPA": "upper_arm", "ELB": "elbow", "FRM": "forearm", "WRA": "wrist.thumb",
            "WRB": "wrist.little", "FIN": "hand", "ASI": "pelvis.front", "PSI": "pelvis.back", "THI": "thigh",
            "KNE": "knee", "TIB": "shank", "ANK": "ankle", "HEE": "heel", "TOE": "toe",
        }),
    },
    {
        **_aliases("{side}{name}", {
            "ASIS": "ASI", "PSIS": "PSI", "ACR": "SHO", "HEEL": "HEE", "MT2": "TOE", "KNEE": "KNE", "ANKLE": "ANK",
            "SHANK": "TIB", "SHN": "TIB", "THIGH": "THI", "WRI": "WRA",
        }),
        "STERN": "STRN", "CV7": "C7", "TV10": "T10", "BAK": "RBAK",
    },
)  # fmt: skip

# Rajagopal et al., Full-body musculoskeletal model for muscle-driven simulation of human gait, 2016: subject 11's data.
RAJAGOPAL = MarkerSet(
    "Rajagopal 2015",
    {
        "S2": "pelvis.back",
        **_both_sides("{side}.{name}", {
            "Shoulder": "shoulder", "Clavicle": "clavicle", "Biceps": "upper_arm", "Elbow": "elbow",
            "Forearm": "forearm", "Wrist": "wrist", "ASIS": "pelvis.front", "PSIS": "pelvis.back", "TH1": "thigh",
            "TH2": "thigh.2", "TH3": "thigh.3", "TH4": "thigh.4", "Knee": "knee", "SH1": "shank", "SH2": "shank.2",
            "SH3": "shank.3", "SH4": "shank.4", "Ankle": "ankle", "Heel": "heel", "MT5": "toe.little", "Toe": "toe",
        }),
        **_both_sides("{side}.{name}", {"MElbow": "elbow.inner", "MKnee": "knee.inner", "MAnkle": "ankle.inner"}),
    },
    {
        **_aliases("{side}.{name}", {
            "ACR": "Shoulder", "SC": "Clavicle", "UA": "Biceps", "LEL": "Elbow", "MEL": "MElbow", "FA": "Forearm",
            "ASI": "ASIS", "PSI": "PSIS", "LFC": "Knee", "MFC": "MKnee", "LMAL": "Ankle", "MMAL": "MAnkle",
            "CAL": "Heel", "TOE1": "Toe",
        }),
        "Sacrum": "S2", "SACR": "S2", "V.Sacral": "S2",
    },
)  # fmt: skip

COMMON_41 = MarkerSet(
    "Baseline 41",
    {
        "HeadTop": "head.top", "HeadFront": "head.front", "HeadSide": "head.side",
        "BackTop": "neck.back", "BackLeft": "back.L", "BackRight": "back.R", "Chest": "sternum",
        **{f"Waist{side}Front": f"pelvis.front.{side}" for side in "LR"},
        **{f"Waist{side}Back": f"pelvis.back.{side}" for side in "LR"},
        **_both_sides("{side}{name}", {
            "ShoulderTop": "shoulder", "ShoulderBack": "back.shoulder", "UArmHigh": "upper_arm", "ElbowOut": "elbow",
            "WristOut": "wrist.little", "WristIn": "wrist.thumb", "HandOut": "hand", "Thigh": "thigh",
            "KneeOut": "knee", "Shin": "shank", "AnkleOut": "ankle", "Heel": "heel", "ToeIn": "toe.big",
            "ToeOut": "toe.little", "ToeTip": "toe.tip",
        }),
    },
    {
        # OptiTrack's newer names, and Helen Hayes' as OpenSim and Cortex write them.
        **_aliases("{side}{name}", {
            "Arm": "UArmHigh", "UpperArm": "UArmHigh", "HeelBack": "Heel", "ForefootIn": "ToeIn",
            "ForefootOut": "ToeOut", "Shoulder": "ShoulderTop", "Elbow": "ElbowOut", "Wrist": "WristOut",
            "Hand": "HandOut", "Knee": "KneeOut", "Shank": "Shin", "Ankle": "AnkleOut", "Toe": "ToeTip",
            "Acromium": "ShoulderTop", "KneeLat": "KneeOut", "AnkleLat": "AnkleOut", "MidfootLat": "ToeOut",
            "BicepsLateral": "UArmHigh", "ThighFront": "Thigh", "ShankFront": "Shin",
        }),
        **{f"{side}.{name}": label for side in "LR" for name, label in (
            ("ASIS", f"Waist{side}Front"), ("PSIS", f"Waist{side}Back"), ("Shoulder", f"{side}ShoulderTop"),
            ("Acromium", f"{side}ShoulderTop"), ("Toe.Tip", f"{side}ToeTip"), ("Knee.Lat", f"{side}KneeOut"),
            ("Ankle.Lat", f"{side}AnkleOut"), ("Midfoot.Lat", f"{side}ToeOut"),
        )},
        "Top.Head": "HeadTop", "Front.Head": "HeadFront", "Rear.Head": "HeadSide", "SpineTop": "BackTop",
        "BackL": "BackLeft", "BackR": "BackRight", "Sternum": "Chest", "ChestTop": "Chest", "HeadL": "HeadSide",
    },
)  # fmt: skip


def _joints(pattern, sides, names):
    """As `_both_sides`, with the sides called as in `sides`, {"L": "Left", ...}."""
    return {
        pattern.format(side=word, name=name): f"{place}.{side}"
        for side, word in sides.items()
        for name, place in names.items()
    }


LEFT_RIGHT, L_R = {"L": "Left", "R": "Right"}, {"L": "L", "R": "R"}
SPINE = {f"Spine{number or ''}": f"spine.{number + 1}" if number else "spine" for number in range(4)}

# Of MotionBuilder, Mixamo, and CMU's motions as they are usually converted.
JOINTS_BY_BONE = MarkerSet(
    "Joints (Hips, LeftUpLeg, LeftLeg)",
    {
        "Hips": "pelvis.joint", **SPINE, "Neck": "neck.joint", "Head": "head.joint", "HeadTop_End": "head.top",
        **_joints("{side}{name}", LEFT_RIGHT, {
            "UpLeg": "hip", "Leg": "knee.joint", "Foot": "ankle.joint", "ToeBase": "toe.joint",
            "ToeBase_end": "toe.tip", "Shoulder": "clavicle.joint",
            "Arm": "shoulder.joint", "ForeArm": "elbow.joint", "Hand": "wrist.joint",
            "HandMiddle1": "hand.joint",
        }),
    },
    {
        "Head_end": "HeadTop_End", "LowerBack": "Spine3", "Pelvis": "Hips", "Chest": "Spine2",
        **{f"{side}{alias}": f"{side}{name}" for side in LEFT_RIGHT.values() for alias, name in (
            ("Toe_End", "ToeBase_end"), ("FingerBase", "HandMiddle1"), ("UpperLeg", "UpLeg"), ("LowerLeg", "Leg"),
            ("UpperArm", "Arm"), ("LowerArm", "ForeArm"), ("Toe", "ToeBase"),
        )},
    },
)  # fmt: skip

# Of Poser and of the older converters: bones are called after the joint that they begin with.
JOINTS_BY_JOINT = MarkerSet(
    "Joints (Hips, LeftHip, LeftKnee)",
    {
        "Hips": "pelvis.joint", "LowerBack": "spine", "Chest": "spine.2", "Chest2": "spine.3", "Neck": "neck.joint",
        "Head": "head.joint", "Head_end": "head.top",
        **_joints("{side}{name}", LEFT_RIGHT, {
            "Hip": "hip", "Knee": "knee.joint", "Ankle": "ankle.joint", "Toe": "toe.joint", "Toe_end": "toe.tip",
            "Collar": "clavicle.joint", "Shoulder": "shoulder.joint", "Elbow": "elbow.joint", "Wrist": "wrist.joint",
        }),
    },
    {**{f"{side}Ankle_end": f"{side}Toe" for side in LEFT_RIGHT.values()}},
)  # fmt: skip

JOINTS_MAKEHUMAN = MarkerSet(
    "Joints (Hips, UpLeg_L, LoLeg_L)",
    {
        "Hips": "pelvis.joint", "Spine1": "spine", "Spine2": "spine.2", "Spine3": "spine.3", "Neck": "neck.joint",
        "Head": "head.joint", "Head_end": "head.top",
        **_joints("{name}_{side}", L_R, {
            "UpLeg": "hip", "LoLeg": "knee.joint", "Foot": "ankle.joint", "Toe": "toe.joint", "Toe_end": "toe.tip",
            "Clavicle": "clavicle.joint", "UpArm": "shoulder.joint", "LoArm": "elbow.joint", "Hand": "wrist.joint",
            "Middle1": "hand.joint",
        }),
    },
    {f"Toe_{side}_end": f"Toe_end_{side}" for side in "LR"},
)  # fmt: skip

JOINTS_MAKEHUMAN_DEFAULT = MarkerSet(
    "Joints (upperleg01.L, lowerleg01.L)",
    {
        "root": "pelvis.joint", **{f"spine0{5 - n}": f"spine.{n + 1}" if n else "spine" for n in range(5)},
        "neck01": "neck.joint", "head": "head.joint", "head_end": "head.top",
        **_joints("{name}.{side}", L_R, {
            "upperleg01": "hip", "upperleg02": "thigh", "lowerleg01": "knee.joint", "lowerleg02": "shank",
            "foot": "ankle.joint", "toe1-1": "toe.joint", "clavicle": "clavicle.joint", "upperarm01": "shoulder.joint",
            "upperarm02": "upper_arm", "lowerarm01": "elbow.joint", "lowerarm02": "forearm", "wrist": "wrist.joint",
            "finger3-1": "hand.joint",
        }),
    },
)  # fmt: skip

BUILT_IN = (
    *(PLUG_IN_GAIT, RAJAGOPAL, COMMON_41),
    *(JOINTS_BY_BONE, JOINTS_BY_JOINT, JOINTS_MAKEHUMAN, JOINTS_MAKEHUMAN_DEFAULT),
)
