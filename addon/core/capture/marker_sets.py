# SPDX-License-Identifier: GPL-3.0-or-later
"""Which marker is where on the body: sets that laboratories use, recognised by their names, kept as JSON presets."""

import json
import re
from dataclasses import dataclass, field

from . import landmarks as places
from .checks import InvalidMotionError

FORMAT = "meanvalue marker set 1"


@dataclass(frozen=True)
class MarkerSet:
    """Labels of a marker set and the landmark of each; other ways to write a label in `aliases` (alias -> label)."""

    name: str
    landmarks: dict
    aliases: dict = field(default_factory=dict)

    def landmark_of(self, label):
        """The landmark of a label or an alias, however it is spelled ("Subject:LASI", "r_knee"); or None."""
        return self._by_key().get(key_of(label))

    def _by_key(self):
        keys = {key_of(label): landmark for label, landmark in self.landmarks.items()}
        return {**{key_of(alias): self.landmarks[label] for alias, label in self.aliases.items()}, **keys}


@dataclass(frozen=True)
class Recognition:
    """What `recognise()` found: the set that fits best and the landmark of each label that was asked for, or None."""

    name: str | None
    landmarks: tuple
    #: Labels that have a landmark, and labels of the set that nobody asked for.
    matched: int
    absent: tuple

    @property
    def words(self):
        """For the artist."""
        if self.name is None:
            return f"None of the {len(self.landmarks)} names is of a known marker set."
        rest = f"; {len(self.absent)} of that set are not there" if self.absent else ""
        return f"{self.name}: {self.matched} of {len(self.landmarks)} names known{rest}."


def key_of(label):
    """A label without what laboratories write differently: prefixes up to ":", case, and what separates words."""
    return re.sub(r"[\s._\-]+", "", label.rsplit(":", 1)[-1]).casefold()


def recognise(labels, more_sets=()):
    """The `Recognition` of labels by the set, built in or of `more_sets`, that knows most of them.

    Of sets that know as many, the one with fewer absent markers. What all labels begin with, up to "_", is left out
    where that helps. Landmarks are not given twice: of two labels for one, the one that is written as the set has it
    is known, else the first.
    """
    labels = list(labels)
    prefix = re.match(r"(.+?_)", labels[0]) if len(labels) > 1 else None
    spellings = [labels]
    if prefix and all(label.startswith(prefix.group(1)) and label != prefix.group(1) for label in labels):
        spellings.append([label[len(prefix.group(1)) :] for label in labels])
    best, none = None, Recognition(None, (None,) * len(labels), 0, ())
    for marker_set in (*more_sets, *BUILT_IN):
        for spelling in spellings:
            found = _landmarks(marker_set, spelling)
            known = {landmark for landmark in found if landmark}
            absent = tuple(label for label, landmark in marker_set.landmarks.items() if landmark not in known)
            candidate = Recognition(marker_set.name, tuple(found), len(known), absent)
            if best is None or (candidate.matched, -len(absent)) > (best.matched, -len(best.absent)):
                best = candidate
    return best if best and best.matched else none


def _landmarks(marker_set, labels):
    """[landmark or None] of the labels, none of them twice."""
    exact = {marker_set.landmarks[label] for label in labels if label in marker_set.landmarks}
    found, taken = [], set()
    for label in labels:
        landmark = marker_set.landmark_of(label)
        is_free = landmark not in taken and (landmark not in exact or label in marker_set.landmarks)
        found.append(landmark if is_free else None)
        taken |= {found[-1]}
    return found


def save(path, marker_set):
    """Writes a preset as JSON. Raises InvalidMotionError where that is impossible."""
    text = json.dumps(
        {"format": FORMAT, "name": marker_set.name, "landmarks": marker_set.landmarks, "aliases": marker_set.aliases},
        indent=1,
        ensure_ascii=False,
    )
    try:
        path.write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise InvalidMotionError(f"The preset can't be written to {path}: {error.strerror}.") from error


def load(path):
    """The `MarkerSet` of a preset. Raises InvalidMotionError with file, reason and remedy for what is none."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InvalidMotionError(f"The preset {path} can't be read: {error.strerror}.") from error
    except (ValueError, RecursionError) as error:
        raise InvalidMotionError(f"{path.name} is no marker preset: it is not JSON ({error}).") from error
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise InvalidMotionError(
            f"{path.name} is no marker preset: its \"format\" must be \"{FORMAT}\". Save the preset again."
        )
    name, landmarks, aliases = content.get("name"), content.get("landmarks"), content.get("aliases", {})
    if not isinstance(name, str) or not name.strip():
        raise InvalidMotionError(f"{path.name}: \"name\" must be the name of the marker set.")
    for key, table in (("landmarks", landmarks), ("aliases", aliases)):
        if not isinstance(table, dict) or not all(isinstance(value, str) for value in table.values()):
            raise InvalidMotionError(f"{path.name}: \"{key}\" must be a table of names.")
    if not landmarks:
        raise InvalidMotionError(f"{path.name}: \"landmarks\" is empty, a marker set needs at least one marker.")
    for label, landmark in landmarks.items():
        if not places.segments_of(landmark):
            known = ", ".join(sorted(places.PLACES))
            raise InvalidMotionError(
                f"{path.name}: '{landmark}' of marker '{label}' is no landmark. Known are {known}; .L or .R the side."
            )
    for alias, label in aliases.items():
        if label not in landmarks:
            raise InvalidMotionError(f"{path.name}: alias '{alias}' is of '{label}', which is no marker of the set.")
    return MarkerSet(name, landmarks, aliases)


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
