# SPDX-License-Identifier: GPL-3.0-or-later
"""Each marker's place on the mesh: a vertex of its own, where the marker is from it, and where its skin goes."""

from dataclasses import dataclass

import numpy as np

from ...errors import InvalidMotionError
from .hip_centres import with_hips
from .marker_graph import marker_graph


@dataclass(frozen=True, eq=False)
class Match:
    """Of each of m markers."""

    #: (m,) the anchor vertex, another one for each marker.
    vertex: np.ndarray
    #: (m, 3) from the anchor vertex to the marker, at rest.
    offset: np.ndarray
    #: (m,) from the marker to the surface, or to a vertex that was given.
    distance: np.ndarray


def match_to_surface(markers, surface, fixed=None):
    """The `Match` of markers (m, 3), aligned, with the Surface nearest to them.

    Anchor vertices are those nearest to the surface points. Where markers compete for one, the first has it, and the
    next takes the nearest that is left. fixed  {marker number: vertex} that are given.
    Raises InvalidMotionError for meshes with less used vertices than markers.
    """
    fixed = fixed or {}
    unknown = [number for number in range(len(markers)) if number not in fixed]
    free = np.setdiff1d(surface.triangles, list(fixed.values()))
    if len(free) < len(unknown):
        raise InvalidMotionError(
            f"The mesh has {len(free)} vertices for {len(unknown)} markers, and each needs one of its own: subdivide it"
        )
    vertex = np.array([fixed.get(number, -1) for number in range(len(markers))])
    _, _, points, distance = surface.nearest(markers)
    for number in unknown:
        nearest = ((surface.vertices[free] - points[number]) ** 2).sum(axis=1).argmin()
        vertex[number] = free[nearest]
        free = np.delete(free, nearest)
    offset = markers - surface.vertices[vertex]
    given = list(fixed)
    distance[given] = np.linalg.norm(offset[given], axis=1)
    return Match(vertex, offset, distance)


def skin_targets(markers, reference, offsets, landmarks):
    """(f, m, 3): where the anchor vertices go. Each marker minus its offset from the skin, turned with the surface.

    The surface at a marker turns from the reference to a frame as the segments of the body do that the marker is of,
    else as the markers around it (Kabsch 1976). What is missing does not count; what the others leave open (one
    neighbor, all on a line) turns as the whole body does. In the reference the targets are the anchor vertices
    themselves, and wherever a segment moves rigidly they are where its skin goes.

    markers  (f, m, 3) in the mesh's space and size: aligned, filled, filtered, retargeted; NaN stay NaN. reference
    (m, 3) the markers that were matched, as aligned. offsets  (m, 3), of Match. landmarks  m names or None.
    """
    # Thighs often have two markers: the hips, which go with the pelvis, tell how they turn.
    rest, moving, names = with_hips(reference, markers, landmarks)
    graph = marker_graph(rest, names, moving)
    turns = graph.of_markers(graph.rotations(rest, moving))[:, : len(reference)]
    return markers - np.einsum("fmij,mj->fmi", turns, offsets)
