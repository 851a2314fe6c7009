# SPDX-License-Identifier: GPL-3.0-or-later
"""The places of a body that markers are put on, by names that do not depend on the laboratory.

A landmark is a name ("knee.L"); without its side ("knee") it is in PLACES. A segment is a part of the body that is
nearly rigid ("thigh.L"), or one that holds two such parts together ("waist", "neck").
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Place:
    """Segments that a landmark belongs to ("*" stands for its side), and its height over that of the standing body.

    Heights are for upright bodies (Drillis and Contini 1966; Winter 2009); None where arms may be anywhere.
    """

    segments: tuple
    height: float | None = None


PLACES = {
    "head.top": Place(("head", "neck"), 1.0),
    "head.front": Place(("head", "neck"), 0.94),
    "head.side": Place(("head", "neck"), 0.94),
    "head.back": Place(("head", "neck"), 0.94),
    "neck.back": Place(("torso", "neck"), 0.85),
    "clavicle": Place(("torso", "neck"), 0.81),
    "sternum": Place(("torso", "waist"), 0.73),
    "back": Place(("torso", "waist"), 0.74),
    "back.shoulder": Place(("torso",), 0.77),
    "shoulder": Place(("torso", "neck", "upper_arm.*"), 0.82),
    "upper_arm": Place(("upper_arm.*",)),
    "elbow": Place(("upper_arm.*", "forearm.*")),
    "elbow.inner": Place(("upper_arm.*", "forearm.*")),
    "forearm": Place(("forearm.*",)),
    "wrist": Place(("forearm.*", "hand.*")),
    "wrist.thumb": Place(("forearm.*", "hand.*")),
    "wrist.little": Place(("forearm.*", "hand.*")),
    "hand": Place(("hand.*", "forearm.*")),
    "hand.thumb": Place(("hand.*", "forearm.*")),
    "pelvis.front": Place(("pelvis", "waist"), 0.56),
    "pelvis.side": Place(("pelvis", "waist"), 0.58),
    "pelvis.back": Place(("pelvis", "waist"), 0.57),
    # The center of the joint: no marker, but found from those of the pelvis (see hip_centres.py).
    "hip": Place(("pelvis", "thigh.*"), 0.53),
    "thigh": Place(("thigh.*",), 0.40),
    "knee": Place(("thigh.*", "shank.*"), 0.285),
    "knee.inner": Place(("thigh.*", "shank.*"), 0.285),
    "shank": Place(("shank.*",), 0.17),
    "ankle": Place(("shank.*", "foot.*"), 0.039),
    "ankle.inner": Place(("shank.*", "foot.*"), 0.039),
    "heel": Place(("foot.*",), 0.02),
    "toe": Place(("foot.*",), 0.02),
    "toe.big": Place(("foot.*",), 0.02),
    "toe.little": Place(("foot.*",), 0.015),
    "toe.tip": Place(("foot.*",), 0.015),
    # What skeletons have in place of markers: centers of joints, inside of the body ("hip" above is one, too).
    "pelvis.joint": Place(("pelvis", "waist"), 0.55),
    "spine": Place(("torso", "waist")),
    "neck.joint": Place(("torso", "neck"), 0.84),
    "head.joint": Place(("head", "neck"), 0.88),
    "clavicle.joint": Place(("torso", "neck")),
    "shoulder.joint": Place(("torso", "neck", "upper_arm.*"), 0.80),
    "elbow.joint": Place(("upper_arm.*", "forearm.*")),
    "wrist.joint": Place(("forearm.*", "hand.*")),
    "hand.joint": Place(("hand.*", "forearm.*")),
    "knee.joint": Place(("thigh.*", "shank.*"), 0.285),
    "ankle.joint": Place(("shank.*", "foot.*"), 0.05),
    "toe.joint": Place(("foot.*",), 0.02),
}

#: Joints of a skeleton without its fingers.
JOINTS = 20

#: First words of the places on an arm.
ARM = ("upper_arm", "elbow", "forearm", "wrist", "hand")

#: Limbs and, of each, places of which one must be known on either side: without them a limb is not brought into the
#: pose of the mesh (limb_posing.py).
LIMBS = {"arms": (("shoulder",), ("elbow",)), "legs": (("knee",), ("hip", "pelvis.front"))}


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
        place, side = place_of(landmark), side_of(landmark)
        if place and side and landmark.startswith(("heel", "toe")):
            result.setdefault(side, []).append(number)
    return result
