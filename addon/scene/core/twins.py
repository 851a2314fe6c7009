# SPDX-License-Identifier: GPL-3.0-or-later
"""Which vertices are each other's mirror image."""

import numpy as np

from ...solver import native_loader
from . import fixed_points, mirror_planes

#: A vertex is the mirror image of another if it is no farther from it than this share of the mesh's size. Nearly all
#: meshes are symmetric to rounding, so the first pairs most vertices, and few are left for the wider search.
TOLERANCES = (1e-6, 1e-3)

#: So far vertices are drawn to the middle of the faces around them, which tells those at one place apart.
TOWARDS = 0.25


def find(rest, face_corners, face_starts, plane):
    """n int32: the mirror image of each vertex, itself for one in the plane, -1 where there is none.

    The arrays are those of a BindInput; plane: unit normal and distance. Each is its twin's twin. Among vertices at one
    place (split edges) the faces around decide.
    """
    points = rest.astype(np.float64)
    size = fixed_points.bounding_box_diagonal(points)
    drawn = points + TOWARDS * (_middles_around(points, face_corners, face_starts) - points)
    matrix, shift = mirror_planes.reflection(plane)
    images, drawn_images = (each @ matrix.T + shift for each in (points, drawn))
    twins = np.full(len(points), -1, np.int32)
    for tolerance in TOLERANCES if size > 0.0 else ():
        left = np.flatnonzero(twins < 0)
        numbers = np.arange(len(left), dtype=np.int32)
        tree = native_loader.module().Surface(drawn[left], np.repeat(numbers[:, None], 3, axis=1))
        nearest = tree.nearest(drawn_images[left])[0]
        apart = np.linalg.norm(images[left] - points[left[nearest]], axis=1)
        is_mutual = (nearest >= 0) & (apart <= tolerance * size) & (nearest[nearest] == numbers)
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
