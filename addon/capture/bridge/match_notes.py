# SPDX-License-Identifier: GPL-3.0-or-later
"""What the artist is told about a matching that could be better."""

from ... import wording
from ..core import landmarks


def of_frame(given, frame):
    """Says so where the take has no frame like the one that was asked for; that one is the nearest."""
    frames = given.standing.frames
    if frames[0] - 1.0 <= given.options.reference_frame <= frames[-1] + 1.0:
        return []
    return [
        f"'{given.reference_name}' has no frame {given.options.reference_frame:g}: it goes from {frames[0]:g} to "
        f"{frames[-1]:g}. Frame {frame:g} was taken as the reference"
    ]


def of_retargeting(given, markers):
    if given.options.mode != 'RETARGET' or any(label in given.picked for label in markers.labels):
        return []
    return [
        "Retarget takes the character's lengths from picked points; none are picked, so lengths are as captured, but "
        "for legs that are an unusual share of the body. Pick the points of hips, knees, ankles, shoulders, elbows and "
        "wrists, and match again"
    ]


def of_placeless(joints):
    """Says which joints of a skeleton have no handle."""
    if not joints:
        return []
    return [
        f"Without a known place on the body, and so without a handle: {wording.counted(len(joints), 'joint')} of the "
        f"skeleton, {wording.quoted(joints)}. They would pull at skin that is not theirs. Choose a Landmark, or pick "
        "the point, of those that should have one"
    ]


def of_limbs(markers):
    """Says so where names do not tell which markers are on arms and legs."""
    unknown = landmarks.unknown_limbs(markers.landmarks)
    if not unknown:
        return []
    known = sum(1 for place in markers.landmarks if place)
    return [
        f"Of {wording.counted(len(markers.labels), 'marker')} the place on the body is known of {known}, and not of "
        f"those that tell how {wording.listed(unknown)} lie, so these are taken as they are in the reference frame, "
        "and the mesh is bent wrongly if it stands otherwise. Choose the Landmark of shoulders, elbows, hips (or the "
        "front of the pelvis) and knees in the list, and match again"
    ]


def of_cuffs(found, refused, most):
    """Sentences: which limbs have a cuff, and which have none as their roll is not known."""
    told = []
    if found:
        told.append(
            f"{wording.counted(len(found), 'cuff')} around limbs: {wording.listed(cuff.segment for cuff in found)}"
        )
    if refused:
        told.append(
            f"No cuff around {wording.listed(sorted(refused))}: the markers there are off a rigid motion by up to "
            f"{max(refused.values()):.2g} of their distance from the limb's axis ({most:.2g} is allowed), so its roll "
            "is not known. One more marker to the side would tell it"
        )
    return told
