# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of markers and of the joints of skeletons, by the landmarks that they stand for."""

import re


def key_of(name):
    """A name without what laboratories write differently: case, what separates words, what says no more."""
    return re.sub(r"_(study|joint|jnt)$|^c_|[\s._\-]+", "", name, flags=re.IGNORECASE).casefold()


def _by_name(central, sided):
    """{key of a name: landmark} of {landmark: names}. Those of `sided` have the side before or behind them, as a word
    or letter: "LKNE", "KneeLeft"."""
    result = {key_of(name): landmark for landmark, names in central.items() for name in names.split()}
    for landmark, names in sided.items():
        for side in ("L", "R", "Left", "Right"):
            for name in names.split():
                places = " ".join(f"{each}.{side[0]}" for each in landmark.split())
                result[key_of(side + name)] = result[key_of(name + side)] = places
    return result


# Plug-in Gait; subject 11 of Rajagopal et al., Full-body musculoskeletal model for muscle-driven simulation of human
# gait, 2016; Baseline 41 and OptiTrack's newer names; Helen Hayes as OpenSim and Cortex write it.
MARKERS = _by_name({
    "head.top": "HeadTop Top.Head", "head.front": "HeadFront Front.Head", "head.side": "HeadSide Rear.Head HeadL Head",
    "neck.back": "C7 CV7 BackTop SpineTop", "clavicle": "CLAV", "sternum": "STRN STERN Sternum Chest ChestTop",
    "back": "T10 TV10", "back.L": "BackLeft BackL", "back.R": "BackRight BackR", "back.shoulder.R": "RBAK RBAC BAK",
    "pelvis.back": "S2 Sacrum SACR V.Sacral WaistBack", "pelvis.front.L": "WaistLFront",
    "pelvis.front.R": "WaistRFront", "pelvis.back.L": "WaistLBack", "pelvis.back.R": "WaistRBack",
}, {
    "head.front": "FHD", "head.back": "BHD", "clavicle": "Clavicle SC", "back.shoulder": "ShoulderBack",
    "shoulder": "SHO ACR Shoulder ShoulderTop Acromium", "elbow": "ELB LEL ElbowOut LElbow Elbow",
    "elbow.inner": "MEL MElbow ElbowIn", "upper_arm": "UPA UA UArmHigh UpperArm Arm Biceps BicepsLateral",
    "forearm": "FRM FA Forearm", "wrist": "Wrist", "wrist.thumb": "WRA WRI WristIn LWrist",
    "wrist.little": "WRB WristOut MWrist", "hand": "FIN HandOut Hand", "pelvis.front": "ASI ASIS FWT",
    "pelvis.side": "Waist", "pelvis.back": "PSI PSIS BWT", "thigh": "THI TH1 Thigh ThighFront Thigh1",
    "thigh.2": "TH2 Thigh2", "thigh.3": "TH3", "thigh.4": "TH4",
    "knee": "KNE LFC Knee KneeOut KneeLat", "knee.inner": "MFC MKnee KneeIn",
    "shank": "TIB SHN SH1 Shank ShankFront Shin Shin1", "shank.2": "SH2 Shin2", "shank.3": "SH3", "shank.4": "SH4",
    "ankle": "ANK LMAL Ankle AnkleOut AnkleLat", "ankle.inner": "MMAL MAnkle", "heel": "HEE CAL CALC Heel HeelBack",
    "toe": "TOE TOE1 MT2", "toe.big": "ToeIn ForefootIn", "toe.little": "MT5 5META ToeOut ForefootOut MidfootLat",
    "toe.tip": "ToeTip",
})  # fmt: skip

# Of MotionBuilder, Mixamo, MakeHuman, game engines, suits with sensors, Poser, motions of research as converted. Of
# names that mean one joint beside some names and another beside others, the first joint counts that no other has.
JOINTS = _by_name({
    "pelvis.joint": "Hips Pelvis root Hip Root_M", "spine": "Spine spine05 L5 LowerBack Abdomen Waist",
    "spine.2": "Spine1 spine04 L3 Chest", "spine.3": "Spine2 spine03 T12 Chest2", "spine.5": "Spine4 spine01 Chest4",
    "spine.4": "Spine3 spine02 T8 Thorax Chest3", "neck.joint": "Neck neck01 neck1 Neck_M neckLower spine.004",
    "head.joint": "Head Head_M spine.006", "head.top": "HeadTop_End Head_end HeadVertex", "toe.tip.L": "Toe_L_end",
    "toe.tip.R": "Toe_R_end",
}, {
    "clavicle.joint": "Clavicle Clav Collar Scapula Shoulder1", "upper_arm": "upperarm02", "forearm": "lowerarm02",
    "shoulder.joint": "Arm UpArm UpperArm upperarm01 Humerus UArm Shldr ShldrBend",
    "elbow.joint": "Elbow ForeArm LoArm LowerArm lowerarm01 Radius LowArm FArm LArm ForearmBend",
    "wrist.joint": "Wrist", "hand.joint": "HandMiddle1 Middle1 Middle01 FingerBase finger3-1",
    "thigh": "upperleg02", "hip": "Hip UpLeg UpperLeg upperleg01 Thigh Femur ThighBend", "shank": "lowerleg02",
    "knee.joint": "Knee LoLeg LowerLeg lowerleg01 Shin Calf Tibia LowLeg Shank", "ankle.joint": "Ankle",
    "toe.joint": "Toe ToeBase Toes Toe0 Ball toe1-1 Ankle_end", "toe.tip": "Toe_End ToeBase_end ToeTip",
    "shoulder.joint clavicle.joint": "Shoulder", "wrist.joint hand.joint": "Hand", "knee.joint hip": "Leg",
    "ankle.joint toe.joint": "Foot",
})  # fmt: skip

# What is found in videos: COCO, Halpe, OpenPose, MediaPipe, depth cameras.
POSE_ESTIMATORS = JOINTS | _by_name(
    {"head.top": "Head", "head.front": "Nose", "pelvis.joint": "Hip MidHip CHip SpineBase Hips_Center",
     "spine.2": "SpineMid Trunk_Center", "spine.3": "Thorax SpineShoulder", "neck.joint": "Neck Neck_Center"},
    {"head.front": "Eye", "head.side": "Ear", "toe.tip": "BigToe FootIndex", "toe.little": "SmallToe", "heel": "Heel"},
)  # fmt: skip

BUILT_IN = (MARKERS, JOINTS, POSE_ESTIMATORS)
