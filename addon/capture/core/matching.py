# SPDX-License-Identifier: GPL-3.0-or-later
"""Each marker's place on the mesh: a vertex of its own, where the marker is from it, and where its skin goes."""

import collections
import itertools
from dataclasses import dataclass

import numpy as np

from ...errors import InvalidMotionError
from ...scene.core.motion import fit_rotations, nearest_rotations
from ...scene.core.point_sets import parts
from . import landmarks as places
from .gaps import distance_variation
from .proportions import with_hips

#: Of each of m markers: (m,) the anchor vertex, another one for each; (m, 3) from that to the marker, at rest; (m,) its
#: distance from the surface, or from a vertex that was given.
Match = collections.namedtuple("Match", "vertex offset distance")


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
    else as the markers around it (Kabsch 1976). What the others leave open (one neighbor, all on a line) turns as the
    whole body does.

    markers  (f, m, 3) in the mesh's space and size; NaN stay NaN. reference  (m, 3) the markers that were matched, as
    aligned. offsets  (m, 3), of Match. landmarks  m names or None.
    """
    # Thighs often have two markers: the hips, which go with the pelvis, tell how they turn.
    rest, moving, names = with_hips(reference, markers, landmarks)
    graph = marker_graph(rest, names, moving)
    turns = nearest_rotations(np.einsum("mc,fcij->fmij", graph.shares, graph.rotations(rest, moving)))
    turns = turns[:, : len(reference)]
    return markers - np.einsum("fmij,mj->fmi", turns, offsets)


#: Markers that make a cell with one whose place on the body is unknown.
NEAREST = 5
#: A marker counts as farther by this many times the standard deviation of its distance.
TOGETHER = 20.0
#: Rows of frames that are worked on at once: some megabytes.
CHUNK = 512


@dataclass(frozen=True, eq=False)
class MarkerGraph:
    """c cells of at most k of m markers, and e edges."""

    members: np.ndarray  # (c, k) marker numbers. A smaller cell is filled up with its first one, at weight 0
    weights: np.ndarray  # (c, k) 1 or 0
    shares: np.ndarray  # (m, c) how much each marker turns with each cell; rows sum to 1
    edges: np.ndarray  # (e, 2) marker numbers, and (e,) the cell that an edge turns with
    cell_of_edge: np.ndarray

    def rotations(self, reference, markers):
        """(f, c, 3, 3): turn of each cell from the reference (m, 3) to each frame of markers (f, m, 3).

        NaN do not count; what a cell leaves open turns as the whole body does.
        """
        body = fit_rotations(reference, markers)
        result = np.empty((len(markers), len(self.members), 3, 3))
        for begin in range(0, len(markers), CHUNK):
            rows = slice(begin, begin + CHUNK)
            result[rows] = fit_rotations(
                reference[self.members], markers[rows][:, self.members], self.weights, body[rows, None]
            )
        return result


def marker_graph(reference, landmarks, markers):
    """The MarkerGraph whose cells are the segments of the body (landmarks.py). A marker that is in none gets a cell of
    its own, with the NEAREST markers that move with it.

    reference  (m, 3); landmarks  m names or None; markers  (f, m, 3), which tell what moves together.
    """
    near = np.linalg.norm(reference[:, None] - reference[None], axis=2)
    variation = distance_variation(markers)
    distances = near + TOGETHER * np.where(np.isfinite(variation), variation, near)
    np.fill_diagonal(distances, 0.0)
    cells = [numbers for _, numbers in sorted(places.segments(landmarks).items())]
    cells_of = [[cell for cell, numbers in enumerate(cells) if number in numbers] for number in range(len(reference))]
    for number, own in enumerate(cells_of):
        if not own:
            own.append(len(cells))
            cells.append(np.argsort(distances[number], kind="stable")[: NEAREST + 1].tolist())
    owners = {}
    for cell, numbers in enumerate(cells):
        for pair in itertools.combinations(numbers, 2):
            owners.setdefault(tuple(sorted(pair)), cell)
    _join(owners, cells_of, near)
    widest = max(map(len, cells))
    return MarkerGraph(
        members=np.array([numbers + numbers[:1] * (widest - len(numbers)) for numbers in cells]),
        weights=np.array([[1.0] * len(numbers) + [0.0] * (widest - len(numbers)) for numbers in cells]),
        shares=np.array([[(cell in own) / len(own) for cell in range(len(cells))] for own in cells_of]),
        edges=np.array(list(owners), int).reshape(-1, 2),
        cell_of_edge=np.array(list(owners.values()), int),
    )


def _join(owners, cells_of, distances):
    """Adds the shortest edges that join all markers into one graph. owners: {edge: its cell}."""
    while (part := parts(np.array(list(owners), int).reshape(-1, 2), len(distances))).any():
        apart = np.where(part[:, None] != part[None], distances, np.inf)
        first, second = (int(k) for k in np.unravel_index(np.argmin(apart), apart.shape))
        owners[min(first, second), max(first, second)] = cells_of[first][0]
