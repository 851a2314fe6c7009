# SPDX-License-Identifier: MPL-2.0
"""Rotations: about an axis, and the ones that fit moved points best."""

import numpy as np


def rotation_about(axis, angle_deg):
    """3 x 3 rotation about an axis (3,) of any length."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.radians(angle_deg)
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def rigid_fit(points, moved):
    """(rotation (3, 3), shift (3,)), moved = points @ rotation.T + shift at best; fewer than 3 points only shift."""
    if len(points) < 3:
        return np.eye(3), moved.mean(axis=0) - points.mean(axis=0)
    centre, moved_centre = points.mean(axis=0), moved.mean(axis=0)
    rotation = nearest_rotations((moved - moved_centre).T @ (points - centre))
    return rotation, moved_centre - rotation @ centre


def nearest_rotations(matrices):
    """Rotations (..., 3, 3) nearest to the matrices (..., 3, 3) in the sum of squares; never reflections."""
    left, _, right = np.linalg.svd(matrices)
    sign = np.sign(np.linalg.det(left @ right))
    left[..., :, 2] *= np.where(sign == 0, 1.0, sign)[..., None]
    return left @ right
