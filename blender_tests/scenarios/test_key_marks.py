# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape keys of the add-on are known by a mark, whatever they are called; those of the artist are never written."""

import bmesh
import bpy
import numpy as np
import pytest
from support import handles, meshes, steps
from support.handles import move
from support.installed import part


def blocks(obj):
    return obj.data.shape_keys.key_blocks


def posed():
    obj, control = handles.tube()
    move(control, (1.0, 0.5, 0.5))
    return obj, control


def test_a_renamed_pose_is_posed_on_before_and_after_undo(tmp_path):
    obj, control = posed()
    blocks(obj)["Mean-Value"].name = "Smile"
    assert obj.meanvalue.result_key == "Smile"
    bpy.ops.ed.undo_push(message="Renamed")
    move(control, (0.5, 0.0, 0.0))
    alone = meshes.seen(obj)
    assert blocks(obj).keys() == ["Basis", "Smile"]
    bpy.ops.ed.undo_push(message="Moved")
    bpy.ops.ed.undo()
    bpy.ops.ed.redo()
    obj = steps.reopened(bpy.data.objects["Tube"], tmp_path / "renamed.blend")
    control = obj.meanvalue.handles["Top"].control
    move(control, (0.5, 0.0, 0.0))
    move(control, (-0.5, 0.0, 0.0))
    assert blocks(obj).keys() == ["Basis", "Smile"]
    assert np.abs(meshes.seen(obj) - alone).max() < 2e-3


def test_what_has_the_name_of_the_pose_by_chance_is_the_artist_s():
    obj, control = handles.tube(live=False)
    obj.shape_key_add(name="Basis")
    own = obj.shape_key_add(name="Mean-Value")
    own.value, own.data[3].co.z = 0.0, 7.0
    obj.meanvalue.live = True
    move(control, (1.0, 0.5, 0.5))
    assert blocks(obj).keys() == ["Basis", "Mean-Value", "Mean-Value.001"]
    assert blocks(obj)["Mean-Value"].data[3].co.z == 7.0
    assert obj.meanvalue.result_key == "Mean-Value.001"


@pytest.mark.parametrize("live", [True, False])
def test_a_pose_whose_range_min_was_set_is_posed_on(live):
    obj, control = posed()
    obj.meanvalue.live = live
    before = meshes.seen(obj)
    for key in blocks(obj):
        key.slider_min = -1.0  # as for all keys at once
    move(control, (0.3, 0.0, 0.0))
    move(control, (-0.3, 0.0, 0.0))
    steps.run(obj, "solve")
    assert blocks(obj).keys() == ["Basis", "Mean-Value"] and np.abs(meshes.seen(obj) - before).max() < 2e-3


def test_copies_of_the_pose_are_the_artist_s():
    obj, control = posed()
    before = handles.shown(obj)
    copy = obj.shape_key_add(name="Copy")  # as Blender 5 duplicates a key, and as joining adds one
    copy.data.foreach_set("co", before.ravel())
    copy.slider_min, copy.value = blocks(obj)["Mean-Value"].slider_min, 0.0
    move(control, (0.5, 0.0, 0.0))
    assert np.array_equal(steps.key_positions(obj, "Copy"), before)
    steps.run(obj, "finish", keep='NOTHING')
    steps.add_handle(obj, "Again", handles.TOP, live=True)
    handles.update()
    move(bpy.context.object, (0.0, 0.5, 0.0))
    assert np.array_equal(steps.key_positions(obj, "Copy"), before)
    assert blocks(obj).keys() == ["Basis", "Copy", "Mean-Value"]


def test_a_joined_object_s_pose_is_not_written():
    obj, control = posed()
    other, _ = handles.tube("Other")
    move(bpy.context.object, (0.0, 0.0, 1.0))
    blocks(other)["Mean-Value"].name = "Theirs"
    meshes.activate(obj)
    other.select_set(True)
    bpy.ops.object.join()
    theirs = steps.key_positions(obj, "Theirs")
    move(control, (0.5, 0.0, 0.0))
    assert np.array_equal(steps.key_positions(obj, "Theirs"), theirs)
    assert blocks(obj)["Theirs"].value == 1.0 and obj.meanvalue.result_key == "Mean-Value"


def test_a_renamed_mix_is_mixed_on():
    obj = meshes.tube(9, 8)
    obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name="Wide")
    key.data.foreach_set("co", (steps.key_positions(obj, "Basis") * (2.0, 2.0, 1.0)).astype(np.float32).ravel())
    obj.meanvalue.mix.is_on = True
    key.value = 1.0
    handles.update()
    for each in blocks(obj):
        each.slider_min = -1.0
    key.value = 0.7
    handles.update()
    handles.update()
    assert blocks(obj).keys() == ["Basis", "Wide", "Rotation-Aware Mix"]
    blocks(obj)["Rotation-Aware Mix"].name = "Turned"
    key.value = 0.5
    handles.update()
    assert blocks(obj).keys() == ["Basis", "Wide", "Turned"]
    obj.meanvalue.mix.is_on = False
    assert blocks(obj).keys() == ["Basis", "Wide"]
    own = obj.shape_key_add(name="Rotation-Aware Mix")
    own.value = 0.0
    obj.meanvalue.mix.is_on = True
    key.value = 0.7
    handles.update()
    assert "Rotation-Aware Mix.001" in blocks(obj)


def test_what_is_off_has_the_value_0():
    """FBX knows nothing of muted keys."""
    obj, control = posed()
    control.keyframe_insert("location", frame=1)
    meshes.activate(obj)
    blocks(obj)["Mean-Value"].name = "Smile"
    assert bpy.ops.meanvalue.bake(target='SHAPE_KEYS', frame_start=1, frame_end=2) == {'FINISHED'}
    key = blocks(obj)["Smile"]
    assert (key.mute, key.value) == (True, 0.0)
    key.name = "Grin"
    assert bpy.ops.meanvalue.unbake() == {'FINISHED'}
    assert (blocks(obj)["Grin"].mute, blocks(obj)["Grin"].value) == (False, 1.0)
    obj.meanvalue.result_key = "Next"
    handles.update()
    assert (blocks(obj)["Grin"].mute, blocks(obj)["Grin"].value, blocks(obj)["Next"].value) == (True, 0.0, 1.0)


def edit_in(mode, obj, name="Mean-Value", vertex=70, offset=0.3):
    meshes.activate(obj)
    obj.active_shape_key_index = blocks(obj).find(name)
    bpy.ops.object.mode_set(mode=mode)
    if mode == 'EDIT':
        bm = bmesh.from_edit_mesh(obj.data)
        bm.verts.ensure_lookup_table()
        bm.verts[vertex].co.y += offset
        bmesh.update_edit_mesh(obj.data)
    else:
        blocks(obj)[name].data[vertex].co.y += offset
    bpy.ops.object.mode_set(mode='OBJECT')
    handles.update()


@pytest.mark.parametrize("mode", ['EDIT', 'SCULPT'])
def test_an_edit_of_the_pose_lies_on_top_of_it(mode):
    obj, control = posed()
    posed_shape = meshes.seen(obj)
    edit_in(mode, obj)
    wanted = posed_shape.copy()
    wanted[70, 1] += 0.3
    assert blocks(obj).keys() == ["Basis", "Mean-Value", "Mean-Value Edit"]
    assert np.abs(meshes.seen(obj) - wanted).max() < 2e-3
    move(control, (0.5, 0.0, 0.0))
    move(control, (-0.5, 0.0, 0.0))
    assert np.abs(meshes.seen(obj) - wanted).max() < 5e-3
    assert blocks(obj).keys() == ["Basis", "Mean-Value", "Mean-Value Edit"]


def test_an_edit_without_live_is_kept_by_the_next_solve(tmp_path):
    obj, _control = posed()
    obj.meanvalue.live = False
    edit_in('EDIT', obj)
    edited = handles.shown(obj)
    obj = steps.reopened(obj, tmp_path / "edited.blend")
    assert bpy.ops.meanvalue.solve() == {'FINISHED'}
    assert np.array_equal(steps.key_positions(obj, "Mean-Value Edit"), edited)
    assert blocks(obj)["Mean-Value Edit"].value == 0.0 and not np.array_equal(handles.shown(obj), edited)
    assert bpy.ops.meanvalue.solve() == {'FINISHED'}
    assert len(blocks(obj)) == 3


@pytest.mark.parametrize(("has_region", "is_live"), [(True, True), (True, False), (False, True)])
def test_the_pose_of_an_object_that_is_joined_is_kept(has_region, is_live):
    """On top of the pose; at value 0 where its part goes along with the handles of the other."""
    shapes = []
    for name, way in (("Second", 1.5), ("First", -1.5)):
        obj = meshes.tube(25, 16, name)
        bpy.ops.meanvalue.grab(vertex=390, offset=(way, 0.0, 0.3), size=0.3)
        obj.meanvalue.roi_group = obj.meanvalue.roi_group if has_region else ""
        obj.location.x = 5.0
        handles.update()
        shapes.append(meshes.seen(obj))
        obj.meanvalue.live = is_live
    meshes.activate(obj)
    bpy.data.objects["Second"].select_set(True)
    bpy.ops.object.join()
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    handles.update()
    if not is_live:
        assert bpy.ops.meanvalue.solve() == {'FINISHED'}
    assert blocks(obj)["Joined Pose"].value == float(has_region)
    blocks(obj)["Joined Pose"].value = 1.0
    handles.update()
    assert np.abs(meshes.seen(obj) - np.concatenate(shapes[::-1])).max() < 5e-3
    move(obj.meanvalue.handles[0].control, (0.0, 0.2, 0.0))
    assert blocks(obj).keys() == ["Basis", "Mean-Value", "Joined Pose"]


@pytest.mark.parametrize("is_live", [True, False])
def test_an_edit_of_the_rest_shape_is_no_edit_of_the_pose(is_live):
    obj, control = posed()
    obj.meanvalue.live = is_live
    edit_in('EDIT', obj, "Basis")
    move(control, (0.5, 0.0, 0.0))
    assert bpy.ops.meanvalue.bind() == {'FINISHED'} == bpy.ops.meanvalue.solve()
    assert blocks(obj).keys() == ["Basis", "Mean-Value"]


def test_a_file_of_before_the_marks_goes_on(tmp_path):
    obj, _control = posed()
    key, settings = blocks(obj)["Mean-Value"], obj.meanvalue
    key.name, key.slider_min = "Lean", 0.0
    settings.result_mark = settings.version = 0
    part("compat").stored(obj)["former_result"] = "Lean"
    obj.shape_key_add(name="Wave").value = 0.0
    settings.live, settings.mix.is_on = False, True
    handles.update()
    with part("live.engine").held():
        blocks(obj)["Rotation-Aware Mix"].slider_min = 0.0
        del obj.data.shape_keys["meanvalue_written_mix"]
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "old.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "old.blend"))
    obj = bpy.data.objects["Tube"]
    for key in blocks(obj):
        key.name = f"{key.name} again"
    assert obj.meanvalue.result_key == "Lean again"
    obj.meanvalue.mix.is_on = False
    assert blocks(obj).keys() == ["Basis again", "Lean again", "Wave again"]


def test_a_mix_of_an_older_file_that_is_appended_is_mixed_on():
    obj = meshes.tube(9, 8)
    obj.shape_key_add(name="Basis")
    obj.shape_key_add(name="Wide").data[3].co.x += 1.0
    obj.meanvalue.mix.is_on = True
    blocks(obj)["Wide"].value = 0.5
    handles.update()
    older = obj.copy()
    older.data = obj.data.copy()
    blocks(older)["Rotation-Aware Mix"].slider_min = 0.0
    del older.data.shape_keys["meanvalue_written_mix"]
    bpy.context.collection.objects.link(older)
    handles.update()
    blocks(older)["Wide"].value = 0.7
    handles.update()
    assert blocks(older).keys() == ["Basis", "Wide", "Rotation-Aware Mix"]
