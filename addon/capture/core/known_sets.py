# SPDX-License-Identifier: GPL-3.0-or-later
"""Marker sets that laboratories use, and the joints of common skeletons: the landmark of each label, and of other ways
to write it."""


def _both_sides(pattern, names, left="L", right="R"):
    """{"LKNE": "knee.L", "RKNE": "knee.R", ...} of {"KNE": "knee"}; `pattern` puts side and name together."""
    return {
        pattern.format(side=word, name=name): f"{place}.{side}"
        for side, word in (("L", left), ("R", right))
        for name, place in names.items()
    }


PLUG_IN_GAIT = {
    "C7": "neck.back", "CV7": "neck.back", "T10": "back", "TV10": "back", "CLAV": "clavicle", "STRN": "sternum",
    "STERN": "sternum", "RBAK": "back.shoulder.R", "BAK": "back.shoulder.R",
    **_both_sides("{side}{name}", {
        "FHD": "head.front", "BHD": "head.back", "SHO": "shoulder", "ACR": "shoulder", "UPA": "upper_arm",
        "ELB": "elbow", "FRM": "forearm", "WRA": "wrist.thumb", "WRI": "wrist.thumb", "WRB": "wrist.little",
        "FIN": "hand", "ASI": "pelvis.front", "ASIS": "pelvis.front", "PSI": "pelvis.back", "PSIS": "pelvis.back",
        "THI": "thigh", "THIGH": "thigh", "KNE": "knee", "KNEE": "knee", "TIB": "shank", "SHANK": "shank",
        "SHN": "shank", "ANK": "ankle", "ANKLE": "ankle", "HEE": "heel", "HEEL": "heel", "TOE": "toe", "MT2": "toe",
    }),
}  # fmt: skip

# Rajagopal et al., Full-body musculoskeletal model for muscle-driven simulation of human gait, 2016: subject 11's data.
RAJAGOPAL = {
    "S2": "pelvis.back", "Sacrum": "pelvis.back", "SACR": "pelvis.back", "V.Sacral": "pelvis.back",
    **_both_sides("{side}.{name}", {
        "Shoulder": "shoulder", "ACR": "shoulder", "Clavicle": "clavicle", "SC": "clavicle", "Biceps": "upper_arm",
        "UA": "upper_arm", "Elbow": "elbow", "LEL": "elbow", "MElbow": "elbow.inner", "MEL": "elbow.inner",
        "Forearm": "forearm", "FA": "forearm", "Wrist": "wrist", "ASIS": "pelvis.front", "ASI": "pelvis.front",
        "PSIS": "pelvis.back", "PSI": "pelvis.back", "TH1": "thigh", "TH2": "thigh.2", "TH3": "thigh.3",
        "TH4": "thigh.4", "Knee": "knee", "LFC": "knee", "MKnee": "knee.inner", "MFC": "knee.inner", "SH1": "shank",
        "SH2": "shank.2", "SH3": "shank.3", "SH4": "shank.4", "Ankle": "ankle", "LMAL": "ankle",
        "MAnkle": "ankle.inner", "MMAL": "ankle.inner", "Heel": "heel", "CAL": "heel", "MT5": "toe.little",
        "Toe": "toe", "TOE1": "toe",
    }),
}  # fmt: skip

# With OptiTrack's newer names, and Helen Hayes' as OpenSim and Cortex write them.
COMMON_41 = {
    "HeadTop": "head.top", "Top.Head": "head.top", "HeadFront": "head.front", "Front.Head": "head.front",
    "HeadSide": "head.side", "Rear.Head": "head.side", "HeadL": "head.side", "BackTop": "neck.back",
    "SpineTop": "neck.back", "BackLeft": "back.L", "BackL": "back.L", "BackRight": "back.R", "BackR": "back.R",
    "Chest": "sternum", "Sternum": "sternum", "ChestTop": "sternum",
    **_both_sides("Waist{side}{name}", {"Front": "pelvis.front", "Back": "pelvis.back"}),
    **_both_sides("{side}{name}", {
        "ShoulderTop": "shoulder", "Shoulder": "shoulder", "Acromium": "shoulder", "ShoulderBack": "back.shoulder",
        "UArmHigh": "upper_arm", "Arm": "upper_arm", "UpperArm": "upper_arm", "BicepsLateral": "upper_arm",
        "ElbowOut": "elbow", "Elbow": "elbow", "WristOut": "wrist.little", "Wrist": "wrist.little",
        "WristIn": "wrist.thumb", "HandOut": "hand", "Hand": "hand", "ASIS": "pelvis.front", "PSIS": "pelvis.back",
        "Thigh": "thigh", "ThighFront": "thigh", "KneeOut": "knee", "Knee": "knee", "KneeLat": "knee", "Shin": "shank",
        "Shank": "shank", "ShankFront": "shank", "AnkleOut": "ankle", "Ankle": "ankle", "AnkleLat": "ankle",
        "Heel": "heel", "HeelBack": "heel", "ToeIn": "toe.big", "ForefootIn": "toe.big", "ToeOut": "toe.little",
        "ForefootOut": "toe.little", "MidfootLat": "toe.little", "ToeTip": "toe.tip", "Toe": "toe.tip",
    }),
}  # fmt: skip

SPINE = {f"Spine{number or ''}": f"spine.{number + 1}" if number else "spine" for number in range(4)}

# Of MotionBuilder, Mixamo, and CMU's motions as they are usually converted.
JOINTS_BY_BONE = {
    "Hips": "pelvis.joint", "Pelvis": "pelvis.joint", **SPINE, "Chest": "spine.3", "LowerBack": "spine.4",
    "Neck": "neck.joint", "Head": "head.joint", "HeadTop_End": "head.top", "Head_end": "head.top",
    **_both_sides("{side}{name}", {
        "UpLeg": "hip", "UpperLeg": "hip", "Leg": "knee.joint", "LowerLeg": "knee.joint", "Foot": "ankle.joint",
        "ToeBase": "toe.joint", "Toe": "toe.joint", "ToeBase_end": "toe.tip", "Toe_End": "toe.tip",
        "Shoulder": "clavicle.joint", "Arm": "shoulder.joint", "UpperArm": "shoulder.joint", "ForeArm": "elbow.joint",
        "LowerArm": "elbow.joint", "Hand": "wrist.joint", "HandMiddle1": "hand.joint", "FingerBase": "hand.joint",
    }, "Left", "Right"),
}  # fmt: skip

# Of Poser and of the older converters: bones are called after the joint that they begin with.
JOINTS_BY_JOINT = {
    "Hips": "pelvis.joint", "LowerBack": "spine", "Chest": "spine.2", "Chest2": "spine.3", "Neck": "neck.joint",
    "Head": "head.joint", "Head_end": "head.top",
    **_both_sides("{side}{name}", {
        "Hip": "hip", "Knee": "knee.joint", "Ankle": "ankle.joint", "Toe": "toe.joint", "Ankle_end": "toe.joint",
        "Toe_end": "toe.tip", "Collar": "clavicle.joint", "Shoulder": "shoulder.joint", "Elbow": "elbow.joint",
        "Wrist": "wrist.joint",
    }, "Left", "Right"),
}  # fmt: skip

JOINTS_MAKEHUMAN = {
    "Hips": "pelvis.joint", "Spine1": "spine", "Spine2": "spine.2", "Spine3": "spine.3", "Neck": "neck.joint",
    "Head": "head.joint", "Head_end": "head.top", "Toe_L_end": "toe.tip.L", "Toe_R_end": "toe.tip.R",
    **_both_sides("{name}_{side}", {
        "UpLeg": "hip", "LoLeg": "knee.joint", "Foot": "ankle.joint", "Toe": "toe.joint", "Toe_end": "toe.tip",
        "Clavicle": "clavicle.joint", "UpArm": "shoulder.joint", "LoArm": "elbow.joint", "Hand": "wrist.joint",
        "Middle1": "hand.joint",
    }),
}  # fmt: skip

JOINTS_MAKEHUMAN_DEFAULT = {
    "root": "pelvis.joint", "spine05": "spine", **{f"spine0{5 - n}": f"spine.{n + 1}" for n in range(1, 5)},
    "neck01": "neck.joint", "head": "head.joint", "head_end": "head.top",
    **_both_sides("{name}.{side}", {
        "upperleg01": "hip", "upperleg02": "thigh", "lowerleg01": "knee.joint", "lowerleg02": "shank",
        "foot": "ankle.joint", "toe1-1": "toe.joint", "clavicle": "clavicle.joint", "upperarm01": "shoulder.joint",
        "upperarm02": "upper_arm", "lowerarm01": "elbow.joint", "lowerarm02": "forearm", "wrist": "wrist.joint",
        "finger3-1": "hand.joint",
    }),
}  # fmt: skip

BUILT_IN = {
    "Plug-in Gait": PLUG_IN_GAIT,
    "Rajagopal 2015": RAJAGOPAL,
    "Baseline 41": COMMON_41,
    "Joints (Hips, LeftUpLeg, LeftLeg)": JOINTS_BY_BONE,
    "Joints (Hips, LeftHip, LeftKnee)": JOINTS_BY_JOINT,
    "Joints (Hips, UpLeg_L, LoLeg_L)": JOINTS_MAKEHUMAN,
    "Joints (upperleg01.L, lowerleg01.L)": JOINTS_MAKEHUMAN_DEFAULT,
}
