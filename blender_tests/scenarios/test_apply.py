# SPDX-License-Identifier: GPL-3.0-or-later
"""The entries of Apply: what is left of handles, keys and the mesh."""

import bpy
import numpy as np
import pytest
from support import handles, meshes
from support.handles import move, rest, shown
from support.snapshot import assert_same, snapshot


def posed_tube():
    """(object, its shape in rest, as posed)."""
    obj, control = handles.tube()
    move(control, (2.0, 0.0, -1.0))
    meshes.activate(obj)
    return obj, rest(obj), shown(obj)


def seen(obj):
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return np.array([vertex.co for vertex in evaluated.data.vertices], np.float32)


def test_cancel_leaves_the_mesh_as_it_was():
    obj = meshes.tube(name="Tube")
    before = snapshot(obj, without=("settings",))
    members = [len(obj.data.vertices) - 1]
    obj.data.vertices.foreach_set("select", np.isin(range(len(obj.data.vertices)), members))
    bpy.ops.object.mode_set(mode='EDIT')
    bpy.ops.meanvalue.add_handle()
    move(obj.meanvalue.handles[0].control, (1.0, 0.0, 0.0))
    meshes.activate(obj)
    assert bpy.ops.meanvalue.finish(keep='NOTHING') == {'FINISHED'}
    assert len(obj.meanvalue.handles) == 0 and not obj.children and obj.data.shape_keys is None
    assert_same(before, snapshot(obj, without=("settings",)))


def test_cancel_leaves_keys_that_were_kept():
    obj, at_rest, posed = posed_tube()
    bpy.ops.meanvalue.keep_pose(name="Lean")
    bpy.ops.meanvalue.finish(keep='NOTHING')
    assert list(obj.data.shape_keys.key_blocks.keys()) == ["Basis", "Lean"]
    assert np.abs(seen(obj) - at_rest).max() < 1e-6
    obj.data.shape_keys.key_blocks["Lean"].value = 1.0
    assert np.abs(seen(obj) - posed).max() < 1e-5


def test_a_pose_that_is_kept_is_there_once():
    obj, _at_rest, posed = posed_tube()
    bpy.ops.meanvalue.keep_pose(name="Lean")
    bpy.ops.meanvalue.finish(keep='SHAPE_KEY')
    assert list(obj.data.shape_keys.key_blocks.keys()) == ["Basis", "Lean"]
    assert np.abs(seen(obj) - posed).max() < 1e-5


@pytest.mark.parametrize("keep", ['SHAPE_KEY', 'REST'])
def test_no_empty_key_is_left_of_what_was_reset(keep):
    obj, at_rest, _posed = posed_tube()
    bpy.ops.meanvalue.keep_pose(name="Lean")
    bpy.ops.meanvalue.reset_handles()
    handles.update()
    bpy.ops.meanvalue.finish(keep=keep)
    assert list(obj.data.shape_keys.key_blocks.keys()) == ["Basis", "Lean"]
    assert np.abs(seen(obj) - at_rest).max() < 1e-5
