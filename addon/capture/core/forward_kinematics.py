# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the joints of a BVH hierarchy are."""

from __future__ import annotations

import numpy as np

from .bvh_hierarchy import Joint


def joint_positions(joints: list[Joint], motion: np.ndarray) -> np.ndarray:
    """(f, j, 3) positions for motion (f, channels) in degrees and units of the file; NaN from where a channel is.

    Rotations are applied in the order of their channels: Z X Y is the matrix Rz Rx Ry.
    """
    positions = np.empty((len(motion), len(joints), 3))
    rotations = []
    for index, joint in enumerate(joints):
        local, rotation = _translation(joint, motion), _rotation(joint, motion)
        if joint.parent < 0:
            positions[:, index] = local
        else:
            around = rotations[joint.parent]
            positions[:, index] = positions[:, joint.parent] + np.einsum("fij,fj->fi", around, local)
            rotation = around @ rotation if not joint.is_end else None
        rotations.append(rotation)
    return positions


def _translation(joint, motion):
    """(f, 3) or (1, 3): from the parent, in its axes.

    Most programs write position channels that replace OFFSET; some write what is added to it. What keeps the bone
    nearer to the length of OFFSET counts, and of roots (that have no bone) only zeros are added.
    """
    added = np.array(joint.offset)[None]
    columns = [(joint.first_channel + k, axis) for k, (is_position, axis) in enumerate(joint.channels) if is_position]
    if not columns:
        return added
    added = np.repeat(added, len(motion), axis=0)
    replaced = added.copy()
    for column, axis in columns:
        replaced[:, axis] = motion[:, column]
        added[:, axis] += motion[:, column]
    if joint.parent < 0:
        return replaced if any(motion[:, column].any() for column, _ in columns) else added
    stretched, kept = (
        np.median(np.abs(np.linalg.norm(way, axis=1) - np.linalg.norm(joint.offset))) for way in (replaced, added)
    )
    return added if kept < stretched else replaced


def _rotation(joint, motion):
    """(f, 3, 3) rotation of a joint against its parent; (1, 3, 3) where it has no rotation channels."""
    result = np.eye(3)[None]
    for k, (is_position, axis) in enumerate(joint.channels):
        if not is_position:
            angles = np.radians(motion[:, joint.first_channel + k])
            first, second = (axis + 1) % 3, (axis + 2) % 3
            turn = np.repeat(np.eye(3)[None], len(angles), axis=0)
            turn[:, first, first] = turn[:, second, second] = np.cos(angles)
            turn[:, second, first] = np.sin(angles)
            turn[:, first, second] = -turn[:, second, first]
            result = result @ turn
    return result
