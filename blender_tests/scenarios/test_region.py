# SPDX-License-Identifier: GPL-3.0-or-later
"""A region of influence: only its vertices may move."""

import bpy
import numpy as np
from support import meshes, steps

ARM = [6, 7, 8, 11, 12, 13, 16, 17, 18]
OUTSIDE = [index for index in range(25) if index not in ARM]


def pose_with_region(anchors=(12,)):
    obj = meshes.grid()
    steps.list_anchors(obj, Handle=anchors)
    steps.add_group(obj, "Region", ARM)
    obj.meanvalue.roi_group = "Region"
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    steps.add_pose_key(obj)
    steps.move(obj, anchors, (0.0, 0.0, 0.8))
    steps.solve()
    return obj


def test_vertices_outside_keep_their_bits():
    obj = pose_with_region()
    rest, result = steps.key_positions(obj, "Basis"), steps.key_positions(obj, "Mean-Value")
    assert np.array_equal(rest[OUTSIDE], result[OUTSIDE])
    moved = np.abs(result - rest).max(axis=1)
    assert (moved[ARM] > 0.01).all()


def test_anchors_outside_the_region_go_to_their_targets():
    obj = pose_with_region(anchors=(12, 24))
    pose, result = steps.key_positions(obj, "Pose"), steps.key_positions(obj, "Mean-Value")
    assert np.array_equal(pose[[12, 24]], result[[12, 24]])
    rest = steps.key_positions(obj, "Basis")
    others = [index for index in OUTSIDE if index != 24]
    assert np.array_equal(rest[others], result[others])
