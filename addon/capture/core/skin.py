# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the skin under each marker goes."""

import numpy as np

from ...scene.core import checks
from .hip_centres import with_hips
from .marker_graph import marker_graph


def skin_targets(markers, reference, match, landmarks=None):
    """(f, m, 3): where the anchor vertices go. Each marker minus its offset from the skin, turned with the surface.

    How the surface at a marker turns from the reference to a frame is fitted to the marker and those around it (of the
    same segments of the body, else the nearest; Kabsch 1976). Neighbours that are missing do not count; what the others
    leave open (one neighbour, all on a line) turns as the whole body does. In the reference the targets are the anchor
    vertices themselves, and wherever a segment moves rigidly they are where its skin goes.

    markers  (f, m, 3) in the mesh's space and size: aligned, filled, filtered, retargeted; NaN stay NaN. reference
    (m, 3) the markers that were matched, as aligned; those that are NaN there have no target. match
    `matching.Match` of them. landmarks  m names or None, of `marker_sets.recognise()`, or None.
    Raises InvalidMotionError where numbers of markers differ, or less than 3 are in the reference.
    """
    markers = checks.motion(markers, "the markers")
    count = markers.shape[1]
    reference = checks.points(reference, "the reference", count)
    if len(match.vertex) != count:
        raise checks.InvalidMotionError(f"The match is of {len(match.vertex)} markers, but there are {count}.")
    known = np.flatnonzero(~np.isnan(reference[:, 0]))
    if len(known) < 3:
        raise checks.InvalidMotionError(
            f"Only {len(known)} markers are in the reference; 3 are needed to tell how the body turns. "
            "Choose another reference frame."
        )
    names = [landmarks[number] if landmarks is not None else None for number in known]
    # Thighs often have two markers: the hips, which go with the pelvis, tell how they turn.
    rest, _, moving, names = with_hips(reference[known], reference[known], markers[:, known], names)
    graph = marker_graph(rest, names, moving)
    turns = graph.of_markers(graph.rotations(rest, moving))[:, : len(known)]
    result = np.full_like(markers, np.nan)
    result[:, known] = markers[:, known] - np.einsum("fmij,mj->fmi", turns, match.offset[known])
    return result
