# SPDX-License-Identifier: GPL-3.0-or-later
"""Rigid and affine moves of handles, as 4 x 4 float64 matrices in the object's space."""

import numpy as np

from . import rigid

IDENTITY = np.eye(4)

#: Matrices that Blender composes from float32 parts agree no better than this, relative to their size.
NOISE = 2e-6


def same(first, second):
    """True if two 4 x 4 matrices differ by no more than float32 noise."""
    scale = max(1.0, float(np.abs(first).max()), float(np.abs(second).max()))
    return bool(np.abs(first - second).max() <= NOISE * scale)


def is_flat(matrix):
    """Whether a 4 x 4 matrix squeezes space, whatever its scale."""
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    return not np.abs(np.linalg.det(matrix[:3, :3])) > 1e-9 * lengths.max(initial=0.0) ** 3


def between(rest_relation, relation):
    """The move that takes `rest_relation` to `relation`, exactly the identity where they agree but for noise.

    Raises numpy.linalg.LinAlgError where the rest relation is flat.
    """
    if same(rest_relation, relation):
        return IDENTITY
    return relation @ np.linalg.inv(rest_relation)


def apply(move, points):
    """n x 3 float64 `points`, moved. The identity keeps their bits."""
    if move is IDENTITY:
        return points.astype(np.float64)
    return points @ move[:3, :3].T + move[:3, 3]


def fitted(before, after):
    """The rigid move (rotation and translation) that takes n x 3 points closest to others (Kabsch 1976).

    Where the points leave the rotation open (one point, a line), the part that they leave open is not turned.
    """
    turn = rigid.fit_rotations(before, after)
    return affine(turn, after.mean(axis=0, dtype=np.float64) - turn @ before.mean(axis=0, dtype=np.float64))


def affine(linear, shift=0.0):
    """4 x 4: x goes to linear x + shift; linear 3 x 3, shift (3,)."""
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = linear, shift
    return result
