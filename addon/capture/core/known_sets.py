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
# gait, 2016; OptiTrack's newer and older names; Helen Hayes as OpenSim and Cortex write it; van Sint Jan's; Shogun's.
MARKERS = _by_name({
    "head.top": "HeadTop Top.Head Head1", "head.front": "HeadFront Front.Head Head2", "back.L": "BackLeft BackL Chest2",
    "clavicle": "CLAV SJN", "back": "T10 TV10",
    "head.side": "HeadSide Rear.Head HeadL Head Head3", "pelvis.back": "S2 Sacrum SACR V.Sacral WaistBack Hip4",
    "neck.back": "C7 CV7 BackTop SpineTop Chest1", "sternum": "STRN STERN Sternum Chest ChestTop SXS",
    "back.R": "BackRight BackR Chest3", "pelvis.front.L": "WaistLFront Hip1", "pelvis.front.R": "WaistRFront Hip2",
    "back.shoulder.R": "RBAK RBAC BAK", "pelvis.back.L": "WaistLBack", "pelvis.back.R": "WaistRBack",
}, {
    "head.front": "FHD", "pelvis.side": "Waist", "shank.2": "SH2 FAX", "toe": "TOE TOE1 MT2 FM2", "toe.tip": "ToeTip",
    "head.back": "BHD", "wrist.2": "Hand3", "thigh.2": "TH2", "thigh.3": "TH3", "thigh.4": "TH4", "shank.3": "SH3",
    "clavicle": "Clavicle SC", "hand": "FIN HandOut Hand Hand1 HM2 HND", "knee.inner": "MFC MKnee KneeIn FME KNI",
    "back.shoulder": "ShoulderBack Shoulder2", "forearm": "FRM FA Forearm", "thigh": "THI TH1 Thigh ThighFront Thigh1",
    "shoulder": "SHO ACR Shoulder ShoulderTop Acromium Shoulder1 SAE", "wrist.thumb": "WRA WRI WristIn LWrist RSP IWR",
    "wrist": "Wrist Hand2", "heel": "HEE CAL CALC Heel HeelBack FCC HEL", "toe.big": "ToeIn ForefootIn Foot1 FM1 MT1",
    "elbow.inner": "MEL MElbow ElbowIn HME IEL", "upper_arm": "UPA UA UArmHigh UpperArm Arm Biceps BicepsLateral UArm2",
    "elbow": "ELB LEL ElbowOut LElbow Elbow HLE UArm1", "knee": "KNE LFC Knee KneeOut KneeLat Thigh2 FLE",
    "wrist.little": "WRB WristOut MWrist USP OWR", "toe.little": "MT5 5META ToeOut ForefootOut MidfootLat Foot2 FM5",
    "pelvis.front": "ASI ASIS FWT IAS", "pelvis.back": "PSI PSIS BWT IPS", "ankle.inner": "MMAL MAnkle TAM",
    "shank": "TIB SHN SH1 Shank ShankFront Shin Shin1 TTC", "ankle": "ANK LMAL Ankle AnkleOut AnkleLat Shin2 FAL",
    "shank.4": "SH4",
})  # fmt: skip

# Of MotionBuilder, Mixamo, MakeHuman, game engines, suits with sensors, Poser, motions of research as converted. Of
# names that mean one joint beside some names and another beside others, the first joint counts that no other has.
JOINTS = _by_name({
    "pelvis.joint": "Hips Pelvis root Hip Root_M", "head.top": "HeadTop_End Head_end HeadVertex",
    "spine": "Spine spine05 L5 LowerBack Abdomen Waist", "neck.joint": "Neck neck01 neck1 Neck_M neckLower spine.004",
    "spine.2": "Spine1 spine04 L3 Chest", "spine.5": "Spine4 spine01 Chest4", "head.joint": "Head Head_M spine.006",
    "spine.3": "Spine2 spine03 T12 Chest2", "spine.4": "Spine3 spine02 T8 Thorax Chest3", "toe.tip.L": "Toe_L_end",
    "toe.tip.R": "Toe_R_end",
}, {
    "clavicle.joint": "Clavicle Clav Collar Scapula Shoulder1", "shank": "lowerleg02",
    "upper_arm": "upperarm02", "shoulder.joint": "Arm UpArm UpperArm upperarm01 Humerus UArm Shldr ShldrBend",
    "forearm": "lowerarm02", "knee.joint": "Knee LoLeg LowerLeg lowerleg01 Shin Calf Tibia LowLeg Shank",
    "elbow.joint": "Elbow ForeArm LoArm LowerArm lowerarm01 Radius LowArm FArm LArm ForearmBend", "thigh": "upperleg02",
    "wrist.joint": "Wrist", "hip": "Hip UpLeg UpperLeg upperleg01 Thigh Femur ThighBend", "ankle.joint": "Ankle",
    "hand.joint": "HandMiddle1 Middle1 Middle01 FingerBase finger3-1", "toe.tip": "Toe_End ToeBase_end ToeTip",
    "toe.joint": "Toe ToeBase Toes Toe0 Ball toe1-1 Ankle_end", "shoulder.joint clavicle.joint": "Shoulder",
    "wrist.joint hand.joint": "Hand", "knee.joint hip": "Leg", "ankle.joint toe.joint": "Foot",
})  # fmt: skip

# What is found in videos: COCO, Halpe, OpenPose, MediaPipe, depth cameras.
POSE_ESTIMATORS = JOINTS | _by_name(
    {"head.front": "Nose", "pelvis.joint": "Hip MidHip CHip SpineBase Hips_Center", "spine.2": "SpineMid Trunk_Center",
     "spine.3": "Thorax SpineShoulder", "neck.joint": "Neck Neck_Center"},
    {"head.front": "Eye", "head.side": "Ear", "toe.tip": "BigToe FootIndex", "toe.little": "SmallToe", "heel": "Heel"},
)  # fmt: skip

BUILT_IN = (MARKERS, JOINTS, POSE_ESTIMATORS)
