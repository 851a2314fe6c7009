# SPDX-License-Identifier: GPL-3.0-or-later
"""A region of influence: only its vertices may move."""

import bpy
import numpy as np
import pytest
from support import meshes, steps

ARM = [6, 7, 8, 11, 12, 13, 16, 17, 18]
OUTSIDE = [index for index in range(25) if index not in ARM]


def pose_with_region(group, invert=False, anchors=(12,)):
    obj = meshes.grid()
    steps.list_anchors(obj, Handle=anchors)
    steps.add_group(obj, "Region", group)
    obj.meanvalue.roi_group = "Region"
    obj.meanvalue.roi_invert = invert
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    steps.add_pose_key(obj)
    steps.move(obj, anchors, (0.0, 0.0, 0.8))
    steps.solve()
    return obj


@pytest.mark.parametrize("group, invert", [(ARM, False), (OUTSIDE, True)])
def test_vertices_outside_keep_their_bits(group, invert):
    obj = pose_with_region(group, invert)
    rest, result = steps.key_positions(obj, "Basis"), steps.key_positions(obj, "Mean-Value")
    assert np.array_equal(rest[OUTSIDE], result[OUTSIDE])
    moved = np.abs(result - rest).max(axis=1)
    assert (moved[ARM] > 0.01).all()


def test_a_soft_group_inverted_leaves_something_free():
    obj = meshes.grid()
    steps.list_anchors(obj, Handle=[12])
    group = steps.add_group(obj, "Region", OUTSIDE)
    group.add(ARM, 0.25, 'REPLACE')
    obj.meanvalue.roi_group, obj.meanvalue.roi_invert = "Region", True
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    assert steps.summary(obj).free_count == 8


def test_anchors_outside_the_region_go_to_their_targets():
    obj = pose_with_region(ARM, anchors=(12, 24))
    pose, result = steps.key_positions(obj, "Pose"), steps.key_positions(obj, "Mean-Value")
    assert np.array_equal(pose[[12, 24]], result[[12, 24]])
    rest = steps.key_positions(obj, "Basis")
    others = [index for index in OUTSIDE if index != 24]
    assert np.array_equal(rest[others], result[others])
