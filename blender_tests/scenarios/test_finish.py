# SPDX-License-Identifier: GPL-3.0-or-later
"""Finish leaves exactly one key for a pose, and nothing where nothing is posed."""

from unittest import mock

import bpy
import numpy as np
import pytest
from support import handles, meshes, steps
from support.handles import move, rest, shown
from support.sheets import BESIDE, COLUMNS, MIDDLE, grab, pin, sheet
from support.snapshot import assert_same, snapshot


def posed_tube():
    obj, control = handles.tube()
    move(control, (1.0, 0.5, 0.5))
    meshes.activate(obj)
    return obj, control


def keys_and_values(obj):
    return sorted((key.name, key.value, key.mute) for key in obj.data.shape_keys.key_blocks[1:])


def test_a_pose_that_was_kept_is_used():
    obj, _control = posed_tube()
    posed = meshes.seen(obj)
    assert bpy.ops.meanvalue.keep_pose(name="Wave") == {'FINISHED'}
    assert bpy.ops.meanvalue.finish() == {'FINISHED'}
    assert keys_and_values(obj) == [("Wave", 1.0, False)]
    assert np.abs(meshes.seen(obj) - posed).max() < 1e-3


def test_a_pose_that_differs_from_what_was_kept_is_a_key_of_its_own():
    obj, control = posed_tube()
    assert bpy.ops.meanvalue.keep_pose(name="Wave") == {'FINISHED'}
    move(control, (0.0, 0.0, 1.0))
    assert bpy.ops.meanvalue.finish() == {'FINISHED'}
    assert keys_and_values(obj) == [("Top Pose", 1.0, False), ("Wave", 1.0, False)]


def test_where_nothing_is_posed_no_key_is_left():
    obj, _control = posed_tube()
    assert bpy.ops.meanvalue.reset_handles() == {'FINISHED'}
    assert bpy.ops.meanvalue.finish() == {'FINISHED'}
    assert obj.data.shape_keys is None


def test_finish_as_shape_key_keeps_what_is_seen_and_removes_the_rest():
    obj = sheet()
    pin(BESIDE)
    grab()
    shape = handles.shown(obj)
    meshes.activate(obj)
    obj.data.shape_keys.key_blocks["Mean-Value"].name = "Bump"
    assert bpy.ops.meanvalue.finish() == {'FINISHED'}
    handles.update()
    assert np.array_equal(steps.key_positions(obj, "Bump"), shape)
    assert obj.data.shape_keys.key_blocks["Bump"].value == 1.0
    assert [len(obj.vertex_groups), len(obj.meanvalue.handles), len(bpy.data.objects)] == [0, 0, 1]
    assert not obj.meanvalue.live and not obj.meanvalue.bound.is_bound and obj.meanvalue.roi_group == ""
    assert bpy.context.object == obj


@pytest.mark.parametrize("has_basis", [False, True])
def test_finish_as_rest_shape_leaves_no_key_but_a_basis_that_the_artist_had(has_basis):
    obj = sheet()
    if has_basis:
        obj.shape_key_add(name="Basis")
    grab()
    shape = handles.shown(obj)
    assert bpy.ops.meanvalue.finish(keep='REST') == {'FINISHED'}
    handles.update()
    keys = obj.data.shape_keys
    assert [key.name for key in (keys.key_blocks if keys else ())] == (["Basis"] if has_basis else [])
    assert np.allclose([tuple(vertex.co) for vertex in obj.data.vertices], shape, atol=1e-6)
    assert np.allclose(meshes.seen(obj), shape, atol=1e-6)


def test_finish_leaves_the_artists_own_groups_and_objects():
    obj = sheet()
    own = meshes.new_object("Own")
    steps.add_group(obj, "Hand", [MIDDLE])
    steps.add_group(obj, "Painted", range(COLUMNS * COLUMNS))
    obj.meanvalue.roi_group = "Painted"
    steps.add_handle(obj, "Feet", range(COLUMNS), pin=True)
    handle = obj.meanvalue.handles.add()
    handle.name, handle.follows = "Hand", 'CONTROL'
    handle.control = own
    assert bpy.ops.meanvalue.finish() == {'FINISHED'}
    assert set(obj.vertex_groups.keys()) == {"Hand", "Painted", "Feet"}
    assert "Own" in bpy.data.objects


def test_a_region_that_the_artist_chose_again_is_the_artists_own():
    obj = sheet()
    steps.add_group(obj, "Painted", range(100))
    grab()
    for name in ("Painted", "Region"):
        obj.meanvalue.roi_group = name
    assert bpy.ops.meanvalue.finish() == {'FINISHED'}
    assert set(obj.vertex_groups.keys()) == {"Painted", "Region"}


def test_finish_and_grab_again_poses_on_top():
    obj = sheet()
    grab()
    bpy.ops.meanvalue.finish()
    grab(vertex=3 * COLUMNS + 3, size=0.1)
    keys = obj.data.shape_keys.key_blocks
    assert [key.value for key in keys][1:] == [1.0, 1.0] and set(keys.keys()) == {"Basis", "Left Pose", "Mean-Value"}


def test_finish_on_a_linked_duplicate_leaves_what_the_other_uses():
    obj = sheet()
    grab()
    other = meshes.duplicate(obj, linked=True)
    other.meanvalue.handles[0].follows = 'REST'
    other.meanvalue.handles[0].control = None
    steps.run(obj, "finish")
    assert steps.held(other, other.meanvalue.handles[0].name) and other.meanvalue.roi_group in other.vertex_groups


def test_what_is_kept_is_not_what_the_next_pose_writes():
    obj = sheet()
    grab()
    meshes.activate(obj)
    obj.shape_key_add(name="Kept Pose", from_mix=False)
    assert bpy.ops.meanvalue.finish() == {'FINISHED'}
    obj.data.shape_keys.key_blocks[1].name = "Mean-Value"
    kept = shown(obj)
    grab()
    assert obj.data.shape_keys.key_blocks.keys() == ["Basis", "Mean-Value", "Kept Pose", "Mean-Value.001"]
    assert np.array_equal(shown(obj), kept)


def test_what_hangs_on_a_control_stays_where_it_is():
    obj = sheet()
    grab()
    hat = meshes.new_object("Hat")
    hat.parent, hat.location = obj.meanvalue.handles[0].control, (1.0, 2.0, 3.0)
    handles.update()
    before = hat.matrix_world.copy()
    steps.run(obj, "finish")
    handles.update()
    assert hat.parent is None and np.allclose(hat.matrix_world, before, atol=1e-5)


def test_discard_pose_and_handles_leaves_the_mesh_as_it_was():
    obj = meshes.tube(name="Tube")
    before = snapshot(obj, without=("settings",))
    members = [len(obj.data.vertices) - 1]
    obj.data.vertices.foreach_set("select", np.isin(range(len(obj.data.vertices)), members))
    bpy.ops.object.mode_set(mode='EDIT')
    bpy.ops.meanvalue.add_handle()
    move(obj.meanvalue.handles[0].control, (1.0, 0.0, 0.0))
    meshes.activate(obj)
    entries, drawn = {}, mock.MagicMock()
    drawn.layout.operator.side_effect = lambda _name, text="", **_more: entries.setdefault(text, mock.MagicMock())
    bpy.types.MEANVALUE_MT_apply.draw(drawn, None)
    assert bpy.ops.meanvalue.finish(keep=entries["Discard Pose and Handles"].keep) == {'FINISHED'}
    assert len(obj.meanvalue.handles) == 0 and not obj.children and obj.data.shape_keys is None
    assert_same(before, snapshot(obj, without=("settings",)))


def test_cancel_leaves_keys_that_were_kept():
    obj, _control = posed_tube()
    at_rest, posed = rest(obj), shown(obj)
    bpy.ops.meanvalue.keep_pose(name="Lean")
    bpy.ops.meanvalue.finish(keep='NOTHING')
    assert list(obj.data.shape_keys.key_blocks.keys()) == ["Basis", "Lean"]
    assert np.abs(meshes.seen(obj) - posed).max() < 1e-5
    obj.data.shape_keys.key_blocks["Lean"].value = 0.0
    assert np.abs(meshes.seen(obj) - at_rest).max() < 1e-6
