# SPDX-License-Identifier: GPL-3.0-or-later
"""Finish leaves exactly one key for a pose, and nothing where nothing is posed."""

import bpy
import numpy as np
from support import handles, meshes
from support.handles import move, update


def posed_tube():
    obj, control = handles.tube()
    move(control, (1.0, 0.5, 0.5))
    meshes.activate(obj)
    return obj, control


def evaluated(obj):
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    return np.array([tuple(vertex.co) for vertex in mesh.vertices])


def keys_and_values(obj):
    return sorted((key.name, key.value, key.mute) for key in obj.data.shape_keys.key_blocks[1:])


def test_a_pose_that_was_kept_is_used():
    obj, _control = posed_tube()
    posed = evaluated(obj)
    assert bpy.ops.meanvalue.keep_pose(name="Wave") == {'FINISHED'}
    assert bpy.ops.meanvalue.finish() == {'FINISHED'}
    assert keys_and_values(obj) == [("Wave", 1.0, False)]
    assert np.abs(evaluated(obj) - posed).max() < 1e-3


def test_a_pose_that_differs_from_what_was_kept_is_a_key_of_its_own():
    obj, control = posed_tube()
    assert bpy.ops.meanvalue.keep_pose(name="Wave") == {'FINISHED'}
    move(control, (0.0, 0.0, 1.0))
    assert bpy.ops.meanvalue.finish() == {'FINISHED'}
    assert keys_and_values(obj) == [("Kept Pose", 1.0, False), ("Wave", 0.0, False)]


def test_after_a_reset_what_was_kept_is_all_that_is_left():
    obj, _control = posed_tube()
    assert bpy.ops.meanvalue.keep_pose(name="Wave") == {'FINISHED'}
    assert bpy.ops.meanvalue.reset_handles() == {'FINISHED'}
    assert bpy.ops.meanvalue.finish() == {'FINISHED'}
    assert keys_and_values(obj) == [("Wave", 0.0, False)]


def test_where_nothing_is_posed_no_key_is_left():
    obj, _control = posed_tube()
    assert bpy.ops.meanvalue.reset_handles() == {'FINISHED'}
    assert bpy.ops.meanvalue.finish() == {'FINISHED'}
    assert obj.data.shape_keys is None


def test_live_turned_on_and_off_without_handles_leaves_nothing():
    obj = meshes.tube()
    obj.meanvalue.live = True
    update()
    obj.meanvalue.live = False
    update()
    assert obj.data.shape_keys is None
