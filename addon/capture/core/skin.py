# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the skin under each marker goes."""

import numpy as np

from .hip_centres import with_hips
from .marker_graph import marker_graph


def skin_targets(markers, reference, offsets, landmarks):
    """(f, m, 3): where the anchor vertices go. Each marker minus its offset from the skin, turned with the surface.

    The surface at a marker turns from the reference to a frame as the segments of the body do that the marker is of,
    else as the markers around it (Kabsch 1976). What is missing does not count; what the others leave open (one
    neighbour, all on a line) turns as the whole body does. In the reference the targets are the anchor vertices
    themselves, and wherever a segment moves rigidly they are where its skin goes.

    markers  (f, m, 3) in the mesh's space and size: aligned, filled, filtered, retargeted; NaN stay NaN. reference
    (m, 3) the markers that were matched, as aligned. offsets  (m, 3), of matching.Match. landmarks  m names or None.
    """
    # Thighs often have two markers: the hips, which go with the pelvis, tell how they turn.
    rest, moving, names = with_hips(reference, markers, landmarks)
    graph = marker_graph(rest, names, moving)
    turns = graph.of_markers(graph.rotations(rest, moving))[:, : len(reference)]
    return markers - np.einsum("fmij,mj->fmi", turns, offsets)
