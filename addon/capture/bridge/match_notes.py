# SPDX-License-Identifier: GPL-3.0-or-later
"""What the artist is told about a matching that could be better."""

from ... import wording
from ..core import cuffs, landmarks

#: Of an automatic alignment (core.alignment.Alignment): from where on the artist is told to look at it.
DOUBTFUL, POOR = 1.1, 0.03


def of_frame(given, frame):
    """Says so where the take has no frame like the one that was asked for; that one is the nearest."""
    frames = given.standing.frames
    if not frames[0] - 1.0 <= given.options.reference_frame <= frames[-1] + 1.0:
        yield (
            f"'{given.standing.name}' has no frame {given.options.reference_frame:g}: it goes from {frames[0]:g} to "
            f"{frames[-1]:g}. Frame {frame:g} was taken as the reference"
        )


def of_retargeting(given, markers):
    if given.options.mode == 'RETARGET' and given.picked.isdisjoint(markers.labels):
        yield (
            "Retarget takes the character's lengths from picked points, and none are picked. Pick the points of hips, "
            "knees, ankles, shoulders, elbows and wrists, and match again"
        )


def of_left_out(given, names):
    """Says which markers have no handle, as they are not on the body, or which joints, as their place is not known."""
    if names:
        what, why = ("joint", "without a known place") if given.is_skeleton else ("marker", "that nothing shows to be")
        yield (
            f"No handle for {wording.counted(len(names), what)} {why} on the body: {wording.quoted(names)}. Choose a "
            "Landmark, or pick the point, of those that should have one"
        )


def of_limbs(markers, scale):
    """Says so where no marker is known to be on arms or legs."""
    unknown = landmarks.unknown_limbs(markers.landmarks)
    if unknown:
        known = sum(1 for place in markers.landmarks if place)
        yield (
            f"Nothing holds {wording.listed(unknown)}, nor tells how they lie: the place on the body is known of "
            f"{known} of {wording.counted(len(markers.labels), 'marker')}, scaled by {scale:.3g}. If there are markers "
            "of shoulders, elbows, hips and knees, choose their Landmark and match again; else pin what should stay"
        )


def of_alignment(found):
    """Says so where an Alignment may be wrong."""
    other = ". Another way to look fits nearly as well" if found.certainty < DOUBTFUL else ""
    if other or found.quality > POOR:
        yield (
            f"Two of three markers lie {wording.share(found.quality)} of the height from the skin, scaled by "
            f"{found.scale:.3g}{other}. If it is wrong, pick three points and align by these"
        )


def of_cuffs(found, refused):
    """Sentences: which limbs have a cuff, and which have none as their roll is not known."""
    if found:
        yield f"{wording.counted(len(found), 'cuff')} around limbs: {wording.listed(cuff.segment for cuff in found)}"
    if refused:
        yield (
            f"No cuff around {wording.listed(sorted(refused))}: the markers there are off a rigid motion by up to "
            f"{max(refused.values()):.2g} of their distance from the axis ({cuffs.ROLL:.2g} is allowed)"
        )
