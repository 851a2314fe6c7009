# SPDX-License-Identifier: GPL-3.0-or-later
"""More than one object, and objects that are more than a plain mesh."""

import bpy
import numpy as np
import pytest
from support import handles, libraries, meshes, steps
from support.snapshot import assert_same, snapshot


def test_a_duplicate_is_bound_and_solves_on_its_own():
    obj = steps.posed_grid(meshes.grid())
    copy = meshes.duplicate(obj)
    assert steps.is_bound(copy)
    meshes.activate(copy)
    steps.move(copy, [24], (0.0, 0.0, 1.0))
    before = snapshot(obj, without=("datablocks",))
    steps.solve()
    assert_same(before, snapshot(obj, without=("datablocks",)))
    assert "Mean-Value" in copy.data.shape_keys.key_blocks


def test_a_mesh_that_another_object_has_in_edit_mode_is_left_alone():
    """Blender has a copy of its own of it then, which comes back when that is left."""
    obj, _control = handles.tube(live=False)
    other = meshes.duplicate(obj, linked=True)
    other.meanvalue.handles.clear()
    meshes.activate(obj)
    bpy.ops.object.mode_set(mode='EDIT')
    bpy.context.view_layer.objects.active = other
    with steps.refused("by another object"):
        bpy.ops.meanvalue.grab(vertex=70, pin=True)
    for operator in (bpy.ops.meanvalue.grow_region, bpy.ops.meanvalue.apply_pose, bpy.ops.meanvalue.bind):
        assert not operator.poll()
    assert not len(other.meanvalue.handles) and not other.meanvalue.roi_group


def test_modifiers_and_where_the_object_stands_do_not_matter():
    plain = steps.posed_grid(meshes.grid(name="Plain"))
    steps.solve()
    other = meshes.grid(name="Other")
    other.location, other.rotation_euler, other.scale = (100.0, -20.0, 3.0), (0.3, 1.2, -2.0), (2.0, -0.5, 3.0)
    other.modifiers.new("Subdivision", 'SUBSURF').levels = 2
    other.modifiers.new("Mirror", 'MIRROR')
    bpy.context.view_layer.update()
    steps.posed_grid(other)
    before = snapshot(other)["modifiers"]
    steps.solve()
    assert snapshot(other)["modifiers"] == before
    assert np.array_equal(steps.key_positions(other, "Mean-Value"), steps.key_positions(plain, "Mean-Value"))


def test_a_control_whose_collection_is_unlinked_for_a_while_stays():
    """With its handle and its animation; only what the artist deletes is gone."""
    obj, control = handles.tube()
    control.keyframe_insert("location", frame=1)
    (home,) = control.users_collection
    parent = bpy.context.scene.collection
    parent.children.unlink(home)
    meshes.activate(obj)
    steps.add_handle(obj, "Middle", handles.MIDDLE, pin=True)
    parent.children.link(home)
    assert obj.meanvalue.handles["Top"].control == control and control.animation_data.action is not None
    handles.move(control, (1.0, 0.0, 0.0))
    assert handles.follows(obj, (1.0, 0.0, 0.0))


def test_without_a_control_of_its_only_handle_a_mesh_has_none(status):
    """The list shows none that could be ticked."""
    obj = meshes.tube(handles.RINGS, handles.SEGMENTS, "Tube")
    bpy.ops.meanvalue.grab(vertex=handles.TOP[0], offset=(1.0, 0.0, 0.0))
    meshes.activate(obj.meanvalue.handles[0].control)
    bpy.ops.object.delete()
    handles.update()
    assert "no handles" in status(obj)[0] and status(obj)[1]


@pytest.mark.parametrize("then", ["add a pin", "save"])
def test_a_control_that_is_deleted_takes_its_handle_along(tmp_path, then):
    obj, _control = handles.tube()
    bpy.ops.object.delete()
    handles.update()
    assert obj.meanvalue.handles["Top"].control is not None  # nothing is written beside Blender's undo
    meshes.activate(obj)
    if then == "save":
        obj = steps.reopened(obj, tmp_path / "file.blend")
    else:
        steps.add_handle(obj, "Low", range(8, 16), pin=True)
    assert "Top" not in obj.meanvalue.handles and not [each for each in bpy.data.objects if each.type == 'EMPTY']


def test_a_mesh_that_is_appended_alone_keeps_its_handles(tmp_path, status):
    """So too where one with the same names was deleted before."""
    path = str(tmp_path / "figure.blend")
    obj, control = handles.tube()
    handles.move(control, (1.0, 0.0, 0.0))
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    for _time in range(2):
        for each in list(bpy.data.objects):
            bpy.data.objects.remove(each)
        (obj,) = libraries.load(path, "objects", ["Tube"])
        meshes.activate(obj)
        posed = handles.shown(obj)
        steps.add_handle(obj, "Middle", handles.MIDDLE, pin=True)
        assert obj.meanvalue.handles.keys() == ["Bottom", "Top", "Middle"]
        handle = obj.meanvalue.handles["Top"]
        assert handle.control is not None and "Press Update" in status(obj)[0]
        assert np.array_equal(handles.shown(obj), posed)
        assert bpy.ops.meanvalue.bind() == {'FINISHED'}
        handles.update()
        assert handles.follows(obj, (1.0, 0.0, 0.0)), status(obj)
        handles.move(handle.control, (1.0, 0.0, 0.0))
        assert handles.follows(obj, (2.0, 0.0, 0.0)), status(obj)
