# SPDX-License-Identifier: GPL-3.0-or-later
"""Which vertices Merge Distance makes one to the solver: open seams and doubles. The artist's mesh is not changed."""

import numpy as np

from ...scene.core import mirror_planes
from ...scene.core.nearness import LEAST_CELL, near_pairs
from ...solver.core.fingerprint import remembered
from . import connected

#: Of the faces' edges: where merging takes more of them away, it merges what is no seam.
MOST_COLLAPSED = 0.02

#: Of more points than these in one cell only the outermost are compared with those of others.
CROWD = 8

#: A direction that neither edges nor planes of modeled meshes are at right angles to: along it they do not pile up.
ALONG = np.array([0.5377, 0.3141, 0.7824])


@remembered
def first_of_place(points, distance):
    """n int: for each of n x 3 points the lowest index of those that steps of at most `distance` lead to.

    Points are joined with all that share a cell whose diagonal is the distance, and then with what is near beyond it.
    Of a crowded cell those that are outermost along an axis stand for all, so that the cost is that of sorting.
    """
    roots = np.arange(len(points))
    near = _may_be_near(np.asarray(points, np.float64), distance)
    roots[near] = near[_joined(points[near].astype(np.float64), distance)]
    return roots


def _may_be_near(points, distance):
    """Ascending numbers of the points that have another one no farther away in one direction, for speed."""
    along = points @ ALONG
    order = np.argsort(along, kind="stable")
    is_near = np.diff(along[order]) <= distance + 1e-14 * np.abs(along).max(initial=0.0)  # rounding
    found = np.zeros(len(points), bool)
    found[order[1:][is_near]] = found[order[:-1][is_near]] = True
    return np.flatnonzero(found)


def _joined(points, distance):
    extent = np.ptp(points, axis=0).max(initial=0.0) if len(points) else 0.0
    cells = np.floor((points - points.min(axis=0, initial=0.0)) / max(0.577 * distance, LEAST_CELL * extent, 1e-300))
    order = np.lexsort(cells.T)
    is_new = np.append(True, (np.diff(cells[order], axis=0) != 0.0).any(axis=1))[: len(points)]
    numbers = np.empty(len(points), np.int64)
    numbers[order] = np.cumsum(is_new) - 1
    roots = connected.parts(np.stack([order, order[np.flatnonzero(is_new)[numbers[order]]]], axis=1), len(points))
    stands = np.bincount(numbers)[numbers] <= CROWD
    for axis in range(3):
        along = np.lexsort((points[:, axis], numbers))
        stands[along[is_new]] = stands[along[np.append(is_new[1:], True)[: len(points)]]] = True
    stands = np.flatnonzero(stands)
    for one, other, _apart in near_pairs(points[stands], points[stands], distance):
        connected.joined(roots, np.stack([stands[one], stands[other]], axis=1))
    return roots


def copies(rest, merge_distance):
    """n int, not to be written to: of n x 3 float32 `rest` the lowest numbered copy of each vertex; None if there is
    nothing to merge."""
    if merge_distance <= 0.0:
        return None
    first = first_of_place(rest, merge_distance)
    return None if np.array_equal(first, np.arange(len(first))) else first


def collapsed_share(rest, face_corners, face_starts, merge_distance):
    """(share, 0 to 1, of the faces' edges with ends apart that are no longer than the merge distance, the longest one,
    rounded down to one figure, that takes no more than MOST_COLLAPSED of them away)."""
    ends = mirror_planes.edge_ends(face_corners, face_starts)
    lengths = np.linalg.norm(rest[face_corners].astype(np.float64) - rest[ends], axis=1)
    lengths = lengths[lengths > 0.0]
    if len(lengths) == 0:
        return 0.0, merge_distance
    harmless = float(np.quantile(lengths, MOST_COLLAPSED, method="lower")) * (1.0 - 1e-6)
    figure = 10.0 ** np.floor(np.log10(harmless))
    return float((lengths <= merge_distance).mean()), float(f"{np.floor(harmless / figure) * figure:.1g}")


def spread(weights, first):
    """n float: the highest of the weights of all copies (`first`, of copies())."""
    if first is None:
        return weights
    found = weights.copy()
    np.maximum.at(found, first, weights)
    return found[first]
