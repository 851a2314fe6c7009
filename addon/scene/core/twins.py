# SPDX-License-Identifier: GPL-3.0-or-later
"""Which vertices are each other's mirror image."""

import numpy as np

from ...solver.core.fingerprint import digest
from . import fixed_points, mirror_planes

#: A vertex is the mirror image of another if it is no farther from it than this share of the mesh's size. Nearly all
#: meshes are symmetric to rounding: what that pairs is out of the way for the wider search.
TOLERANCES = (1e-6, 1e-3)

#: Where more vertices than this are so near to one another, which is whose image is not looked for: each would be
#: compared with all others.
MOST_TOGETHER = 64

#: Pairs are remembered for so many meshes: a mesh is read again after every edit of anything.
REMEMBERED = 4

_remembered = {}


def find(rest, face_corners, face_starts, plane):
    """n int32: the mirror image of each vertex, itself for one in the plane, -1 where there is none.

    As of a BindInput; plane: unit normal and distance. Each is its twin's twin. Among vertices at one place (split
    edges) the faces around decide. Not to be written to.
    """
    key = digest(rest, face_corners, face_starts, np.asarray(plane, np.float64))
    if key not in _remembered:
        while len(_remembered) >= REMEMBERED:
            del _remembered[next(iter(_remembered))]
        _remembered[key] = _found(rest.astype(np.float64), face_corners, face_starts, plane)
        _remembered[key].flags.writeable = False
    return _remembered[key]


def _found(points, corners, starts, plane):
    size = fixed_points.bounding_box_diagonal(points)
    middles = _middles_around(points, corners, starts)
    matrix, shift = mirror_planes.reflection(plane)
    images, image_middles = points @ matrix.T + shift, middles @ matrix.T + shift
    twins = np.full(len(points), -1, np.int32)
    for tolerance in TOLERANCES:
        left = np.flatnonzero(twins < 0)
        if len(left) and size > 0.0:
            nearest = _nearest(images[left], image_middles[left], points[left], middles[left], tolerance * size)
            is_mutual = (nearest >= 0) & (nearest[nearest] == np.arange(len(left)))
            twins[left[is_mutual]] = left[nearest[is_mutual]]
    return twins


def _middles_around(points, corners, starts):
    """n x 3: the mean of the middles of the faces around each vertex; the vertex itself where there are none."""
    if len(starts) == 0:
        return points.copy()
    sizes = np.diff(np.append(starts, len(corners)))
    faces = np.repeat(np.arange(len(starts)), sizes)
    centres = np.stack([np.bincount(faces, points[corners, axis]) for axis in range(3)], axis=1) / sizes[:, None]
    counts = np.bincount(corners, minlength=len(points))
    sums = [np.bincount(corners, centres[faces, axis], len(points)) for axis in range(3)]
    return np.where(counts[:, None] > 0, np.stack(sums, axis=1) / np.maximum(counts, 1)[:, None], points)


def _nearest(wanted, wanted_middles, points, middles, distance):
    """m ints: the point at most `distance` from each wanted place whose surroundings are nearest, -1 for none,
    and where there are more than MOST_TOGETHER.

    Points are sorted into cells of twice that: what is near enough is in one of eight.
    """
    cell = 2.0 * distance
    corner = np.minimum(points.min(axis=0), wanted.min(axis=0)) - 2.0 * cell
    counts = (np.ceil((np.maximum(points.max(axis=0), wanted.max(axis=0)) - corner) / cell) + 3).astype(np.int64)

    def keys(cells):
        return (cells[:, 0] * counts[1] + cells[:, 1]) * counts[2] + cells[:, 2]

    own = keys(((points - corner) / cell).astype(np.int64))
    order = np.argsort(own, kind="stable")
    own = own[order]
    lowest = ((wanted - corner) / cell - 0.5).astype(np.int64)
    best, found = np.full(len(wanted), np.inf), np.full(len(wanted), -1)
    is_crowded = np.zeros(len(wanted), bool)
    for number in range(8):
        cells = keys(lowest + np.array([number & 1, number >> 1 & 1, number >> 2]))
        begin, end = np.searchsorted(own, cells, "left"), np.searchsorted(own, cells, "right")
        is_crowded |= end - begin > MOST_TOGETHER
        end = np.where(is_crowded, begin, end)
        for step in range(int((end - begin).max(initial=0))):
            asking = np.flatnonzero(begin + step < end)
            candidates = order[begin[asking] + step]
            apart = ((wanted[asking] - points[candidates]) ** 2).sum(axis=1)
            unlike = apart + ((wanted_middles[asking] - middles[candidates]) ** 2).sum(axis=1)
            is_better = (apart <= distance**2) & (unlike < best[asking])
            best[asking[is_better]] = unlike[is_better]
            found[asking[is_better]] = candidates[is_better]
    found[is_crowded] = -1
    return found
