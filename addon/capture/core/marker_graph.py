# SPDX-License-Identifier: GPL-3.0-or-later
"""Which markers move together: cells of markers that are about rigid, and the edges in them."""

from dataclasses import dataclass

import numpy as np

from ...scene.core.rigid import fit_rotations
from . import landmarks as places
from .gaps import distance_variation

#: Nearest markers that make a cell with one whose place on the body is unknown.
NEAREST = 5
#: How much farther a marker counts as whose distance varies (standard deviation).
TOGETHER = 20.0
#: Rows of frames that are worked on at once: some megabytes.
CHUNK = 512


@dataclass(frozen=True, eq=False)
class MarkerGraph:
    """c cells of at most k of m markers, and e edges."""

    #: (c, k) marker numbers; where a cell has less than k, its first again, with weight 0.
    members: np.ndarray
    #: (c, k) 1 or 0.
    weights: np.ndarray
    #: (e, 2) marker numbers, and (e,) the cell that an edge turns with.
    edges: np.ndarray
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


def by_segments(reference, landmarks):
    """The graph whose cells are the segments of the body (landmarks.py); other markers form cells with their NEAREST.

    reference  (m, 3), no NaN; landmarks  m names or None.
    """
    cells = [numbers for _, numbers in sorted(places.segments(landmarks).items())]
    placed = {number for numbers in cells for number in numbers}
    distances = np.linalg.norm(reference[:, None] - reference[None], axis=2)
    for number in range(len(reference)):
        if number not in placed:
            cells.append(np.argsort(distances[number], kind="stable")[: NEAREST + 1].tolist())
    edges, owners, seen = [], [], set()
    for cell, numbers in enumerate(cells):
        for k, first in enumerate(numbers):
            for second in numbers[k + 1 :]:
                pair = (min(first, second), max(first, second))
                if pair not in seen:
                    seen.add(pair)
                    edges.append(pair)
                    owners.append(cell)
    edges, owners = _joined(edges, owners, distances)
    return MarkerGraph(*_padded(cells), np.array(edges, int).reshape(-1, 2), np.array(owners, int))


def around_markers(reference, landmarks, markers):
    """The graph with one cell for each marker, without edges: those of its segments, or NEAREST that move with it.

    reference  (m, 3), no NaN; landmarks  m names or None; markers  (f, m, 3), from which is seen what moves together.
    """
    near = np.linalg.norm(reference[:, None] - reference[None], axis=2)
    variation = distance_variation(markers)
    distances = near + TOGETHER * np.where(np.isfinite(variation), variation, near)
    segments = places.segments(landmarks)
    cells = []
    for number in range(len(reference)):
        mates = {mate for numbers in segments.values() if number in numbers for mate in numbers} - {number}
        order = [int(mate) for mate in np.argsort(distances[number], kind="stable") if mate != number]
        near = [mate for mate in order if mate in mates][: NEAREST + 1]
        if len(near) < 2:
            near += [mate for mate in order if mate not in near][: NEAREST - len(near)]
        cells.append([number, *near])
    return MarkerGraph(*_padded(cells), np.zeros((0, 2), int), np.zeros(0, int))


def _padded(cells):
    widest = max((len(numbers) for numbers in cells), default=1)
    members = np.array([[*numbers, *[numbers[0]] * (widest - len(numbers))] for numbers in cells], int)
    weights = np.array([[1.0] * len(numbers) + [0.0] * (widest - len(numbers)) for numbers in cells])
    return members.reshape(-1, widest), weights.reshape(-1, widest)


def _joined(edges, owners, distances):
    """The edges, and the shortest ones that join what they leave in several parts (turning with any cell nearby)."""
    edges, owners = list(edges), list(owners)
    part = np.arange(len(distances))
    cell_of = {}
    for (first, second), owner in zip(edges, owners, strict=True):
        part[part == part[first]] = part[second]
        cell_of.setdefault(first, owner)
        cell_of.setdefault(second, owner)
    while len(np.unique(part)) > 1:
        apart = np.where(part[:, None] != part[None], distances, np.inf)
        first, second = (int(k) for k in np.unravel_index(np.argmin(apart), apart.shape))
        edges.append((min(first, second), max(first, second)))
        owners.append(cell_of.get(first, cell_of.get(second, 0)))
        part[part == part[first]] = part[second]
    return edges, owners
