# SPDX-License-Identifier: GPL-3.0-or-later
"""The artist's whole way, by operators only."""

import bpy
import numpy as np
import pytest
from support import handles, meshes, steps
from support.handles import BOTTOM, TOP
from support.snapshot import assert_same, snapshot


def native_result(native, obj, pose_name, anchors, roi=None):
    """The answer of the compiled module for the same arrays, with the triangles that Blender shows."""
    rest = steps.key_positions(obj, "Basis")
    mesh = obj.data
    mesh.calc_loop_triangles()
    triangles = np.array([tuple(triangle.vertices) for triangle in mesh.loop_triangles], np.int32)
    handles = np.array([vertex_handle(obj, anchor) for anchor in anchors], np.int32)
    anchors = np.array(anchors, np.int32)
    deformer = native.Deformer(rest.astype(np.float64), triangles, anchors, roi=roi, handles=handles)
    targets = steps.key_positions(obj, pose_name)[anchors].astype(np.float64)
    return deformer.solve(targets, settle=True).vertices.astype(np.float32)


def vertex_handle(obj, vertex):
    return next(n for n, handle in enumerate(obj.meanvalue.handles) if vertex in steps.held(obj, handle.name))


def closed_with_ngons():
    obj = meshes.tube()
    steps.list_anchors(obj, Bottom=range(8), Top=range(64, 72))
    steps.add_pose_key(obj)
    steps.move(obj, range(64, 72), (1.0, 0.0, 0.5))
    return obj, [*range(8), *range(64, 72)]


@pytest.mark.parametrize("make", [lambda: (steps.posed_grid(meshes.grid()), [0, 4, 20, 24]), closed_with_ngons])
def test_result_is_the_native_answer_to_the_last_bit(native, make):
    obj, anchors = make()
    steps.move(obj, [12], (3.0, 3.0, 3.0))  # the anchors of the pose key alone count
    steps.solve()
    expected = native_result(native, obj, "Pose", anchors)
    result = steps.key_positions(obj, "Mean-Value")
    assert np.array_equal(result, expected)
    assert np.abs(result - steps.key_positions(obj, "Basis")).max() > 0.5


def test_unbind_forgets_the_binding_only():
    obj = steps.posed_grid(meshes.grid())
    steps.solve()
    before = snapshot(obj, without=("settings",))
    assert bpy.ops.meanvalue.unbind() == {'FINISHED'}
    assert_same(before, snapshot(obj, without=("settings",)))
    assert not obj.meanvalue.bound.is_bound
    assert [handle.name for handle in obj.meanvalue.handles] == ["Corners", "Tip"]
    steps.solve()
    assert obj.meanvalue.bound.is_bound


def test_solve_touches_nothing_but_its_shape_key():
    obj = meshes.textured_grid()
    steps.posed_grid(obj)
    changing = ("keys", "settings", "datablocks")
    before = snapshot(obj, without=changing)
    keys_before = snapshot(obj)["keys"]
    steps.solve()
    assert_same(before, snapshot(obj, without=changing))
    basis, pose, result = snapshot(obj)["keys"]
    assert basis == keys_before[0]
    assert pose[-1] == keys_before[1][-1]
    assert result[0] == "Mean-Value"
    assert {len(polygon.vertices) for polygon in obj.data.polygons} == {4}


def test_bind_changes_nothing_but_its_record():
    obj = meshes.textured_grid()
    steps.list_anchors(obj, A=[0, 4, 20])
    before = snapshot(obj, without=("settings",))
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    assert_same(before, snapshot(obj, without=("settings",)))
    assert obj.meanvalue.bound.is_bound
    assert (steps.summary(obj).anchor_count, steps.summary(obj).free_count) == (3, 22)


def test_a_result_key_with_odd_settings_is_shown_fully_all_the_same():
    obj = steps.posed_grid(meshes.grid())
    key = obj.shape_key_add(name="Mean-Value", from_mix=False)
    obj.meanvalue.result_key = "Mean-Value"  # chosen: else what has that name by chance is the artist's
    key.slider_max = 0.5
    key.mute = True
    key.relative_key = obj.data.shape_keys.key_blocks["Pose"]
    key.vertex_group = "Corners"
    obj.active_shape_key_index = 1
    steps.solve()
    shown = meshes.seen(obj)
    assert np.abs(shown - steps.key_positions(obj, "Mean-Value")).max() < 1e-6


def test_the_result_key_may_be_the_pose_key():
    obj = steps.posed_grid(meshes.grid())
    target = steps.key_positions(obj, "Pose")[24]
    obj.meanvalue.result_key = "Pose"
    steps.solve()
    keys = obj.data.shape_keys.key_blocks
    assert keys.keys() == ["Basis", "Pose"]
    assert (keys["Pose"].value, keys["Pose"].mute) == (1.0, False)
    result = steps.key_positions(obj, "Pose")
    assert np.array_equal(result[24], target)
    steps.solve()  # its own answer is a pose with the same anchors
    assert np.array_equal(steps.key_positions(obj, "Pose"), result)


def test_posing_in_edit_mode():
    obj = steps.bound_grid(meshes.grid())
    steps.add_pose_key(obj)

    def lift_tip(bm):
        bm.verts.ensure_lookup_table()
        bm.verts[24].co.z += 1.0

    steps.edit_mesh(obj, lift_tip)
    rest = steps.key_positions(obj, "Basis")
    steps.solve()
    result = steps.key_positions(obj, "Mean-Value")
    assert result[24, 2] == pytest.approx(rest[24, 2] + 1.0, abs=1e-6)
    assert result[18, 2] > rest[18, 2] + 0.1
    assert np.array_equal(steps.key_positions(obj, "Basis"), rest)


def test_saved_and_reopened_it_is_still_bound_and_gives_the_same(tmp_path):
    obj = steps.posed_grid(meshes.grid())
    steps.solve()
    before = steps.key_positions(obj, "Mean-Value")
    obj = steps.reopened(obj, tmp_path / "posed.blend")
    assert np.array_equal(steps.key_positions(obj, "Mean-Value"), before)
    assert steps.is_bound(obj)
    steps.move(obj, range(25), (9.0, 9.0, 9.0), obj.data.shape_keys.key_blocks["Mean-Value"])
    steps.solve()
    assert np.array_equal(steps.key_positions(obj, "Mean-Value"), before)


# -- a region of influence: only its vertices may move -----------------------------------------------------------------


ARM = [6, 7, 8, 11, 12, 13, 16, 17, 18]


def test_with_a_region_others_keep_their_bits_and_anchors_anywhere_go_to_their_targets():
    obj, anchors = meshes.grid(), (12, 24)
    steps.list_anchors(obj, Handle=anchors)
    steps.add_group(obj, "Region", ARM)
    obj.meanvalue.roi_group = "Region"
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    steps.add_pose_key(obj)
    steps.move(obj, anchors, (0.0, 0.0, 0.8))
    steps.solve()
    rest, pose, result = (steps.key_positions(obj, name) for name in ("Basis", "Pose", "Mean-Value"))
    assert np.array_equal(pose[[12, 24]], result[[12, 24]])
    others = [index for index in range(24) if index not in ARM]
    assert np.array_equal(rest[others], result[others])
    moved = np.abs(result - rest).max(axis=1)
    assert (moved[ARM] > 0.01).all()


# -- Solve from Shape Key: the places of handles are those of a key, once ----------------------------------------------


@pytest.fixture
def posed():
    """A tube without handles, with two vertex groups, and a key in which one of them was moved."""
    obj = meshes.tube(handles.RINGS, handles.SEGMENTS)
    steps.add_group(obj, "feet", BOTTOM)
    steps.add_group(obj, "hand", TOP)
    steps.add_pose_key(obj)
    steps.move(obj, TOP, (1.0, 0.5, 0.0))
    return obj


def pin(obj, *groups):
    for group in groups:
        assert bpy.ops.meanvalue.add_handle(group=group, pin=True) == {'FINISHED'}


def test_pins_go_where_the_key_has_them_and_the_key_is_not_added(posed):
    pin(posed, "hand", "feet")
    assert bpy.ops.meanvalue.solve_from_key() == {'FINISHED'}
    keys, shown = posed.data.shape_keys.key_blocks, meshes.seen(posed)
    assert (keys["Pose"].value, keys["Mean-Value"].value) == (0.0, 1.0)
    assert np.abs(shown[TOP] - steps.key_positions(posed, "Pose")[TOP]).max() < 1e-5
    middle = slice(8 * handles.SEGMENTS, 9 * handles.SEGMENTS)
    assert np.abs(shown - steps.key_positions(posed, "Basis"))[middle].max() > 0.1


@pytest.mark.parametrize(
    "groups, key, text", [(["hand", "feet"], "Smile", "no shape key 'Smile'"), ([], "", "no handles yet")]
)
def test_what_is_missing_is_told_before_anything_is_changed(posed, groups, key, text):
    pin(posed, *groups)
    with steps.refused(text, unchanged=posed):
        bpy.ops.meanvalue.solve_from_key(key=key)


def test_nothing_follows_afterwards():
    obj, control = handles.tube()
    meshes.activate(obj)
    steps.add_pose_key(obj)
    steps.move(obj, TOP, (0.0, 1.0, 0.0))
    assert bpy.ops.meanvalue.solve_from_key() == {'FINISHED'}
    assert not obj.meanvalue.live
    solved = meshes.seen(obj)
    steps.move(obj, TOP, (0.0, 1.0, 0.0))
    handles.move(control, (1.0, 0.0, 0.0))
    assert np.array_equal(meshes.seen(obj), solved)
    assert np.abs(solved[TOP] - steps.key_positions(obj, "Basis")[TOP] - (0.0, 1.0, 0.0)).max() < 1e-5
