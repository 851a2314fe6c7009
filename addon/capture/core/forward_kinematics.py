# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the joints of a BVH hierarchy are."""

from __future__ import annotations

import numpy as np

from .bvh_hierarchy import Joint


def rest_positions(joints: list[Joint]) -> np.ndarray:
    """(j, 3) positions by the offsets alone, with roots at the origin."""
    rest = np.zeros((len(joints), 3))
    for index, joint in enumerate(joints):
        if joint.parent >= 0:
            rest[index] = rest[joint.parent] + joint.offset
    return rest


def joint_positions(joints: list[Joint], motion: np.ndarray) -> np.ndarray:
    """(f, j, 3) positions for motion (f, channels) in degrees and units of the file; NaN from where a channel is.

    Rotations are applied in the order of their channels: Z X Y is the matrix Rz Rx Ry.
    """
    positions = np.empty((len(motion), len(joints), 3))
    to_come = [0] * len(joints)  # children that still need the rotation
    for joint in joints:
        if joint.parent >= 0:
            to_come[joint.parent] += 1
    rotations = {}
    for index, joint in enumerate(joints):
        local = translation(joint, motion)
        if joint.parent < 0:
            positions[:, index] = local
            rotation = _rotation(joint, motion)
        else:
            around = rotations[joint.parent]
            positions[:, index] = positions[:, joint.parent] + np.einsum("fij,fj->fi", around, local)
            rotation = around @ _rotation(joint, motion) if to_come[index] else None
            to_come[joint.parent] -= 1
            if to_come[joint.parent] == 0:
                del rotations[joint.parent]
        if to_come[index]:
            rotations[index] = rotation
    return positions


def translation(joint: Joint, motion: np.ndarray) -> np.ndarray:
    """(f, 3) or (1, 3): from the parent, in its axes.

    Most programs write position channels that replace OFFSET; some write what is added to it. What keeps the bone
    nearer to the length of OFFSET counts, and of roots (that have no bone) only zeros are added.
    """
    offset = np.asarray(joint.offset)
    local = np.repeat(offset[None], len(motion) if any(is_position for is_position, _ in joint.channels) else 1, axis=0)
    columns = [(joint.first_channel + k, axis) for k, (is_position, axis) in enumerate(joint.channels) if is_position]
    if not columns:
        return local
    replaced = local.copy()
    for column, axis in columns:
        replaced[:, axis] = motion[:, column]
        local[:, axis] += motion[:, column]
    if joint.parent < 0:
        return local if all(not motion[:, column].any() for column, _ in columns) else replaced
    length = np.linalg.norm(offset)
    stretched, kept = (np.median(np.abs(np.linalg.norm(way, axis=1) - length)) for way in (replaced, local))
    return local if kept < stretched else replaced


def _rotation(joint, motion):
    """(f, 3, 3) rotation of a joint against its parent; (1, 3, 3) where it has no rotation channels."""
    result = np.eye(3)[None]
    for k, (is_position, axis) in enumerate(joint.channels):
        if not is_position:
            result = result @ _about(axis, np.radians(motion[:, joint.first_channel + k]))
    return result


def _about(axis, angles):
    cosines, sines = np.cos(angles), np.sin(angles)
    matrices = np.zeros((len(angles), 3, 3))
    first, second = (axis + 1) % 3, (axis + 2) % 3
    matrices[:, axis, axis] = 1.0
    matrices[:, first, first] = matrices[:, second, second] = cosines
    matrices[:, second, first] = sines
    matrices[:, first, second] = -sines
    return matrices
