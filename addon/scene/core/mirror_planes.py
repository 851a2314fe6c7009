# SPDX-License-Identifier: GPL-3.0-or-later
"""Planes that mirror a mesh: (unit normal, distance from the origin along it); which vertices are mirror images."""

import numpy as np

from ...solver import native_loader
from . import point_sets


def reflection(plane):
    """(3 x 3, 3 numbers): x goes to matrix x + vector. plane: unit normal and distance from the origin along it."""
    normal = np.asarray(plane[:3], np.float64)
    return np.eye(3) - 2.0 * np.outer(normal, normal), 2.0 * plane[3] * normal


def edge_ends(face_corners, face_starts):
    """Where the edge from each face corner goes to: the next corner of its face."""
    following = np.append(face_corners[1:], face_corners[:1])
    following[np.append(face_starts[1:], len(face_corners)) - 1] = face_corners[face_starts]
    return following


def is_a_border(seam, face_corners, face_starts):
    """Whether the mesh ends at the vertices of n bool `seam`: a half does. One that goes on beyond the plane, or does
    not reach it, has nothing to be joined to there."""
    if not seam.any():
        return False
    inside = np.count_nonzero(seam[face_corners] & seam[edge_ends(face_corners, face_starts)])
    borders = native_loader.module().border_edges(len(seam), face_corners, face_starts)
    # At least half of the edges: one that is no border is there twice. Or single vertices touch the plane.
    return bool(3 * np.count_nonzero(seam[borders].all(axis=1)) >= inside)


def needed(planes, twins, roi, anchors):
    """(planes, twins) of a BindInput without the planes whose seam nothing moves; (None, None) for none."""
    if planes is None:
        return None, None
    moves = roi.copy()
    moves[anchors] = True
    is_needed = [bool(moves[twin >= 0].any()) for twin in twins]
    return (planes[is_needed], twins[is_needed]) if any(is_needed) else (None, None)


#: A vertex is the mirror image of another if it is no farther from it than this share of the mesh's size. Nearly all
#: meshes are symmetric to rounding, so the first pairs most vertices, and few are left for the wider search.
TOLERANCES = (1e-6, 1e-3)

#: So far vertices are drawn to the middle of the faces around them, which tells those at one place apart.
TOWARDS = 0.25


def partners(rest, face_corners, face_starts, plane):
    """n int32: the mirror image of each vertex, itself for one in the plane, -1 where there is none.

    The arrays are those of a BindInput; plane: unit normal and distance. Each is its twin's twin. Among vertices at one
    place (split edges) the faces around decide.
    """
    points = rest.astype(np.float64)
    size = point_sets.bounding_box_diagonal(points)
    drawn = points + TOWARDS * (_middles_around(points, face_corners, face_starts) - points)
    matrix, shift = reflection(plane)
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
