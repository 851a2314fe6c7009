# SPDX-License-Identifier: GPL-3.0-or-later
"""Which marker is where on the body: sets that laboratories use, recognised by their names, which may begin with a
subject, the person or thing that wears the marker. And which points of a file are none (angles, forces, what a model
computed): C3D tells by parameters of its group POINT, ANGLES, FORCES, ...; all else shows by the names alone.
"""

import os.path
import re
from typing import NamedTuple

from .landmarks import has_joints

#: How a subject is put before a name: "Subject:LASI", "Subject_LASI", "Skeleton 001_LASI".
SUBJECTS = (r"(.*:)(.*)", *(rf"((?:[^:_ ]+[_ ]){{{words}}})(.+)" for words in (1, 2, 3)))


class Recognition(NamedTuple):
    """The landmark of each label that was asked for, or None; numbers of labels that props or another person wear."""

    landmarks: tuple
    others: tuple


def recognise(labels, is_skeleton=False):
    """The `Recognition` of labels by the set that knows most of them. is_skeleton: they are known to be joints.

    Else names are of joints only if most of them are. Landmarks are not given twice: of two labels for one, that
    is known which the set has first, else the shorter.
    """
    best = Recognition((None,) * len(labels), ())
    most = sorted(labels)[len(labels) // 4 : 1 + 3 * len(labels) // 4]  # they begin alike: "mixamorigHips"
    for pattern in (*SUBJECTS, f"({re.escape(os.path.commonprefix(most))})(.+)"):
        parts = [re.fullmatch(pattern, label, re.DOTALL) or ("", "", label) for label in labels]
        for marker_set in BUILT_IN:
            found = _of_one(marker_set, [part[1] for part in parts], [part[2] for part in parts])
            is_possible = has_joints(found.landmarks) or is_skeleton == has_joints(marker_set.values())
            if is_possible and found.landmarks.count(None) < best.landmarks.count(None):
                best = found
    return best


def _of_one(marker_set, subjects, names):
    """The Recognition of one person: the subject of which most is known, and those with what he has not (gloves)."""
    keys, rank = [key_of(name) for name in names], {key: number for number, key in enumerate(marker_set)}
    known = [marker_set.get(key) for key in keys]
    members, found, others, taken = {}, [None] * len(names), [], set()
    for number in sorted(range(len(names)), key=lambda number: (rank.get(keys[number], 0), len(names[number]))):
        members.setdefault(subjects[number], []).append(number)
    of_each = [(subject, numbers, {known[k] for k in numbers} - {None}) for subject, numbers in members.items()]
    for subject, numbers, own in sorted(of_each, key=lambda each: -len(each[2])):
        if taken and (own & taken or (subject and not own)):
            others += numbers
            continue
        for number in numbers:
            free = [place for place in (known[number] or "").split() if place not in taken]
            found[number] = free[0] if free else None
            taken.update(free[:1])
    return Recognition(tuple(found), tuple(others))


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
    "spine": "Spine spine05 L5 LowerBack Abdomen Waist Ab",
    "neck.joint": "Neck neck01 neck1 Neck_M neckLower lowerNeck spine.004",
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
    {"head.front": "Nose", "pelvis.joint": "Hip MidHip CHip SpineBase Hip_Center Hips_Center",
     "spine.2": "SpineMid Spine_Navel", "spine.3": "Thorax SpineShoulder Spine_Chest Trunk_Center",
     "neck.joint": "Neck Neck_Center Shoulder_Center"},
    {"head.front": "Eye", "head.side": "Ear", "toe.tip": "BigToe FootIndex", "toe.little": "SmallToe", "heel": "Heel",
     "head.front.2": "EyeInner", "head.front.3": "EyeOuter", "head.front.4": "Mouth", "hand.joint": "Index",
     "hand.2": "Pinky", "hand.thumb": "Thumb"},
)  # fmt: skip

#: Points that some write by number, of MediaPipe and of OpenPose, by how many there are.
NUMBERED = {len(names.split()): names.split() for names in (
    "nose left_eye_inner left_eye left_eye_outer right_eye_inner right_eye right_eye_outer left_ear right_ear "
    "mouth_left mouth_right left_shoulder right_shoulder left_elbow right_elbow left_wrist right_wrist left_pinky "
    "right_pinky left_index right_index left_thumb right_thumb left_hip right_hip left_knee right_knee left_ankle "
    "right_ankle left_heel right_heel left_foot_index right_foot_index",
    "Nose Neck RShoulder RElbow RWrist LShoulder LElbow LWrist MidHip RHip RKnee RAnkle LHip LKnee LAnkle REye LEye "
    "REar LEar LBigToe LSmallToe LHeel RBigToe RSmallToe RHeel",
)}  # fmt: skip

BUILT_IN = (MARKERS, JOINTS, POSE_ESTIMATORS)


#: Parameter of POINT that lists labels -> what they are.
KINDS = {name: name.lower() for name in ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS", "REACTIONS")}
KINDS |= dict.fromkeys(("MODELED_MARKERS", "MODELLED_MARKERS", "VIRTUAL_MARKERS"), "virtual points")
KINDS |= {"BONES": "segment axes"}
UNLABELLED = "unlabelled points"

#: Names of points that no marker can be: joint centers, center of mass, V_ for virtual (Motion Analysis), what is on
#: the ground below others or in the middle of two.
_VIRTUAL_NAME = re.compile(
    r"""(?: .*[:._\s] )?
        (?: cent(?:er|re)_?of_?mass(?:_?floor)? | com(?:_?floor)?
          | [lr]?[haksew]jc
          | .*joint[._\s]?cent(?:er|re) | .*(?:hip|knee|ankle|shoulder|elbow|wrist)[._\s]?joint(?:[._\s]?ground)?
          | (?:head|shoulder|hip|knee|ankle|heel|toe|mt5)[._\s]?ground
          | mid[._\s]?(?:asis|psis|clavicle|shoulders?|hips?|knees?|ankles?|pelvis)
          | v_.+ )""",
    re.IGNORECASE | re.VERBOSE,
)


def listed_in(parameters) -> dict[str, str]:
    """{label: kind} that a C3D file tells by its parameters."""
    kinds = dict(KINDS)
    types = parameters.strings("POINT", "TYPE_GROUPS")  # pairs: the parameter, and what one of it is called
    for name in types[0::2]:
        kinds.setdefault(name.upper(), name.lower())
    for name in ("LABELS", "DESCRIPTIONS", "UNITS", ""):
        kinds.pop(name, None)
    return {label: kind for name, kind in kinds.items() for label in parameters.all_strings("POINT", name)}


def kinds(labels: list[str], listed: dict[str, str] | None = None) -> list[str | None]:
    """For each label its kind, None for a marker. `listed`: {label: kind} that the file itself tells."""
    known = {**(listed or {}), **_segment_axes(labels), "": None}
    return [known.get(label) or _kind_by_name(label) for label in labels]


def _kind_by_name(label):
    if re.fullmatch(r"\*\d+|(unlabell?ed|new) ?\d+", label, re.IGNORECASE):  # of Vicon, Motive, Qualisys: nobody's
        return UNLABELLED
    return "virtual points" if len(label) < 100 and _VIRTUAL_NAME.fullmatch(label) else None


def _segment_axes(labels):
    """{label: kind} of origin and ends of the three axes of body segments, as Plug-in Gait names them: PELO, PELA, PELL
    and PELP."""
    present = set(labels)
    stems = [label[:-1] for label in present if len(label) > 1 and {label[:-1] + end for end in "OALP"} <= present]
    return {stem + end: "segment axes" for stem in stems for end in "OALP"}
