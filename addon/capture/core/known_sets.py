# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of markers and of the joints of skeletons, by the landmarks that they stand for."""

import re


def key_of(name):
    """A name without what laboratories write differently: case, what separates words, what OpenCap puts behind."""
    return re.sub(r"_study$|[\s._\-]+", "", name).casefold()


def _by_name(central, sided):
    """{key of a name: landmark} of {landmark: names}. Those of `sided` have the side before or behind them, as a word
    or letter: "LKNE", "KneeLeft"."""
    result = {key_of(name): landmark for landmark, names in central.items() for name in names.split()}
    for landmark, names in sided.items():
        for side in ("L", "R", "Left", "Right"):
            for name in names.split():
                result[key_of(side + name)] = result[key_of(name + side)] = f"{landmark}.{side[0]}"
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

# Bones begin with the joint: of MotionBuilder, Mixamo, MakeHuman, game engines, and motions of research as converted.
JOINTS_BY_BONE = _by_name({
    "pelvis.joint": "Hips Pelvis root", "spine": "Spine spine05 L5", "spine.2": "Spine1 spine04 L3",
    "spine.3": "Spine2 Chest spine03 T12", "spine.4": "Spine3 LowerBack spine02 T8 Thorax", "spine.5": "Spine4 spine01",
    "neck.joint": "Neck neck01", "head.joint": "Head", "head.top": "HeadTop_End Head_end", "toe.tip.L": "Toe_L_end",
    "toe.tip.R": "Toe_R_end",
}, {
    "clavicle.joint": "Shoulder Clavicle Clav", "shoulder.joint": "Arm UpArm UpperArm upperarm01 Humerus",
    "upper_arm": "upperarm02", "elbow.joint": "ForeArm LoArm LowerArm lowerarm01 Radius", "forearm": "lowerarm02",
    "wrist.joint": "Hand Wrist", "hand.joint": "HandMiddle1 Middle1 Middle01 FingerBase finger3-1",
    "thigh": "upperleg02", "hip": "UpLeg UpperLeg upperleg01 Thigh Femur",
    "knee.joint": "Leg LoLeg LowerLeg lowerleg01 Shin Calf Tibia", "shank": "lowerleg02", "ankle.joint": "Foot",
    "toe.joint": "Toe ToeBase Toes Toe0 Ball toe1-1", "toe.tip": "Toe_End ToeBase_end",
})  # fmt: skip

# Of Poser, of the older converters, of motions of research: bones are called after the joint that they begin with.
JOINTS_BY_JOINT = _by_name({
    "pelvis.joint": "Hips Pelvis", "spine": "LowerBack Spine1", "spine.2": "Chest Spine2",
    "spine.3": "Chest2 Spine3", "spine.4": "Chest3", "spine.5": "Chest4",
    "neck.joint": "Neck", "head.joint": "Head", "head.top": "Head_end",
}, {
    "clavicle.joint": "Collar", "shoulder.joint": "Shoulder", "elbow.joint": "Elbow", "wrist.joint": "Wrist",
    "hand.joint": "Hand", "hip": "Hip", "knee.joint": "Knee", "ankle.joint": "Ankle",
    "toe.joint": "Toe Foot Ankle_end", "toe.tip": "Toe_end",
})  # fmt: skip

# What is found in videos: COCO, Halpe, OpenPose, MediaPipe, depth cameras.
POSE_ESTIMATORS = JOINTS_BY_JOINT | _by_name(
    {"head.top": "Head", "head.front": "Nose", "pelvis.joint": "Hip MidHip CHip SpineBase Hips_Center",
     "spine.2": "SpineMid Trunk_Center", "spine.3": "Thorax SpineShoulder", "neck.joint": "Neck Neck_Center"},
    {"head.front": "Eye", "head.side": "Ear", "toe.tip": "BigToe FootIndex", "toe.little": "SmallToe", "heel": "Heel"},
)  # fmt: skip

BUILT_IN = (MARKERS, JOINTS_BY_BONE, JOINTS_BY_JOINT, POSE_ESTIMATORS)
