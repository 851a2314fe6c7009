# SPDX-License-Identifier: GPL-3.0-or-later
"""The places of a body that markers are put on, by names that do not depend on the laboratory.

A landmark is a name ("knee.L"); without its side ("knee") it is in PLACES. A segment is a part of the body that is
nearly rigid ("thigh.L"), or one that holds two such parts together ("waist", "neck").
"""

import collections

import numpy as np

#: Segments that a landmark belongs to ("*" stands for its side), and its height over that of the standing body.
#: Heights are for upright bodies (Drillis and Contini 1966; Winter 2009); None where arms may be anywhere.
Place = collections.namedtuple("Place", "segments height", defaults=[None])

#: {landmarks that lie alike: their place}. The hip is the center of the joint: no marker, but found from those of the
#: pelvis (proportions.py).
_PLACES = {
    "head.top": Place(("head", "neck"), 1.0),
    "head.front head.side head.back": Place(("head", "neck"), 0.94),
    "head.joint": Place(("head", "neck"), 0.88),
    "neck.back": Place(("torso", "neck"), 0.85),
    "neck.joint": Place(("torso", "neck"), 0.84),
    "clavicle": Place(("torso", "neck"), 0.81),
    "clavicle.joint": Place(("torso", "neck")),
    "sternum": Place(("torso", "waist"), 0.73),
    "back": Place(("torso", "waist"), 0.74),
    "spine": Place(("torso", "waist")),
    "back.shoulder": Place(("torso",), 0.77),
    "shoulder": Place(("torso", "neck", "upper_arm.*"), 0.82),
    "shoulder.joint": Place(("torso", "neck", "upper_arm.*"), 0.80),
    "upper_arm": Place(("upper_arm.*",)),
    "elbow elbow.inner elbow.joint": Place(("upper_arm.*", "forearm.*")),
    "forearm": Place(("forearm.*",)),
    "wrist wrist.thumb wrist.little wrist.joint": Place(("forearm.*", "hand.*")),
    "hand hand.thumb hand.joint": Place(("hand.*", "forearm.*")),
    "pelvis.front": Place(("pelvis", "waist"), 0.56),
    "pelvis.side": Place(("pelvis", "waist"), 0.58),
    "pelvis.back": Place(("pelvis", "waist"), 0.57),
    "pelvis.joint": Place(("pelvis", "waist"), 0.55),
    "hip": Place(("pelvis", "thigh.*"), 0.53),
    "thigh": Place(("thigh.*",), 0.40),
    "knee knee.inner knee.joint": Place(("thigh.*", "shank.*"), 0.285),
    "shank": Place(("shank.*",), 0.17),
    "ankle ankle.inner": Place(("shank.*", "foot.*"), 0.039),
    "ankle.joint": Place(("shank.*", "foot.*"), 0.05),
    "heel toe toe.big toe.joint": Place(("foot.*",), 0.02),
    "toe.little toe.tip": Place(("foot.*",), 0.015),
}
PLACES = {name: place for names, place in _PLACES.items() for name in names.split()}

#: Joints of a skeleton without its fingers.
JOINTS = 20

#: First words of the places on an arm.
ARM = ("upper_arm", "elbow", "forearm", "wrist", "hand")

#: Limbs and, of each, places of which one must be known on either side: without them a limb is not brought into the
#: pose of the mesh (limb_posing.py), or its end goes where it will, as through the floor.
LIMBS = {"arms": (("shoulder",), ("elbow",), ("wrist", "hand")),
         "legs": (("hip", "pelvis.front"), ("knee",), ("ankle", "heel", "toe"))}  # fmt: skip


def side_of(landmark):
    """ "L", "R", or None for the middle of the body and for None."""
    return landmark[-1] if landmark and landmark[-2:] in (".L", ".R") else None


def place_of(landmark):
    """The `Place`, or None for None and for names that are not known. "thigh.2.L" is a second place on the thigh."""
    if not landmark:
        return None
    name = landmark[:-2] if side_of(landmark) else landmark
    head, _, tail = name.rpartition(".")
    return PLACES.get(head if tail.isdigit() else name)


def heights_of(landmarks):
    """(m,) over that of the standing body, of names or None; NaN where none is known."""
    return np.array([(place.height if place else None) or np.nan for place in map(place_of, landmarks)])


def segments_of(landmark):
    """Names of the segments that a landmark belongs to, with its side; () for what is not known."""
    place, side = place_of(landmark), side_of(landmark)
    return tuple(segment.replace("*", side or "?") for segment in place.segments) if place else ()


def segments(landmarks):
    """Segment -> indices in `landmarks` (names or None), of the segments with at least two of them."""
    members = {}
    for number, landmark in enumerate(landmarks):
        for segment in segments_of(landmark):
            members.setdefault(segment, []).append(number)
    # Not every set has markers at the lower torso: then the upper one is what the pelvis is joined to.
    if len(set(members.get("waist", ())) & set(members.get("torso", ()))) < 3:
        members["waist"] = sorted({*members.get("waist", ()), *members.get("torso", ())})
    return {segment: numbers for segment, numbers in members.items() if len(numbers) > 1}


def has_joints(landmarks):
    """True if most of landmarks (names or None), or of the JOINTS that a skeleton has without its fingers, are joints,
    inside of the body, and no markers on its skin."""
    joints = [name for name in landmarks if name and (".joint" in name or name in ("hip.L", "hip.R"))]
    return 2 * len(joints) >= max(1, min(len(landmarks), JOINTS))


def unknown_limbs(landmarks):
    """Those of LIMBS for which, on one side or both, landmarks (names or None) tell too little."""
    known = {landmark for landmark in landmarks if landmark}

    def has(places, side):
        return any(side_of(name) == side and name.startswith(places) for name in known)

    return [limb for limb, needed in LIMBS.items() if not all(has(some, side) for some in needed for side in "LR")]


def feet(landmarks):
    """{"L": [...], "R": [...]}: indices of the landmarks that touch the ground; {} without."""
    result = {}
    for number, landmark in enumerate(landmarks):
        if side_of(landmark) and landmark.startswith(("heel", "toe")):
            result.setdefault(side_of(landmark), []).append(number)
    return result
