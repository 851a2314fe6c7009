# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangles that were turned over."""

import numpy as np

from ...scene.core.rigid import nearest_rotations


def flipped(rest, shape, triangles):
    """(m,) bool: triangles that point against what their surroundings make of their rest normal.

    For each vertex the rotation is found that carries the edges of its triangles from rest to shape at best; the sum of
    those of a triangle's corners, made a rotation again, carries its rest normal. Flipped is whose normal is more than
    90 degrees off that. A fold of one triangle counts; a part that turned as a whole does not, and what is folded at
    rest may stay so.

    rest, shape: (n, 3); triangles: (m, 3) vertex numbers.
    """
    edges = unique_edges(triangles)
    moved, still = (each[edges[:, 1]] - each[edges[:, 0]] for each in (shape, rest))
    products = np.einsum("ei,ej->eij", moved, still)
    moments = np.zeros((len(rest), 3, 3))
    for end in (0, 1):
        np.add.at(moments, edges[:, end], products)
    turns = nearest_rotations(nearest_rotations(moments)[triangles].sum(axis=1))
    expected = np.einsum("mij,mj->mi", turns, crosses(rest, triangles))
    return np.einsum("mj,mj->m", expected, crosses(shape, triangles)) < 0.0


def unique_edges(triangles):
    """(e, 2) vertex numbers, the smaller first, each pair once, ascending."""
    pairs = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    return np.unique(pairs, axis=0)


def crosses(points, triangles):
    """(m, 3): normals, as long as twice the area."""
    corners = points[triangles]
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
