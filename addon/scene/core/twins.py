# SPDX-License-Identifier: GPL-3.0-or-later
"""Which vertices are each other's mirror image."""

import numpy as np

from ...solver.core.fingerprint import remembered
from . import fixed_points, mirror_planes
from .nearness import near_pairs

#: A vertex is the mirror image of another if it is no farther from it than this share of the mesh's size. Nearly all
#: meshes are symmetric to rounding, so the first pairs most vertices, and few are left for the wider search.
TOLERANCES = (1e-6, 1e-3)

#: If more vertices than this are so near to one another, their images are not looked for: each would be compared with
#: all others.
MOST_TOGETHER = 64


@remembered
def find(rest, face_corners, face_starts, plane):
    """n int32: the mirror image of each vertex, itself for one in the plane, -1 where there is none.

    The arrays are those of a BindInput; plane: unit normal and distance. Each is its twin's twin. Among vertices at one
    place (split edges) the faces around decide.
    """
    points = rest.astype(np.float64)
    size = fixed_points.bounding_box_diagonal(points)
    middles = _middles_around(points, face_corners, face_starts)
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
    """m ints: the point at most `distance` from each wanted place whose surroundings are nearest, -1 for none."""
    best, found = np.full(len(wanted), np.inf), np.full(len(wanted), -1)
    for asking, candidates, apart in near_pairs(wanted, points, distance, MOST_TOGETHER):
        unlike = apart + ((wanted_middles[asking] - middles[candidates]) ** 2).sum(axis=1)
        is_better = unlike < best[asking]
        best[asking[is_better]] = unlike[is_better]
        found[asking[is_better]] = candidates[is_better]
    return found
