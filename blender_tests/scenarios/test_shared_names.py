# SPDX-License-Identifier: GPL-3.0-or-later
"""What is made must not be somebody else's by its name, its mesh or its control."""

import bpy
import numpy as np
import pytest
from support import armatures, handles, meshes, rigs, steps
from support.handles import TOP, move, shown, update
from support.snapshot import assert_same, snapshot


def skinned(*bones):
    """A tube on two bones, bent, and on others that no vertex has a weight for."""
    obj = meshes.tube(handles.RINGS, handles.SEGMENTS, "Tube")
    more = dict.fromkeys(bones, ((0.0, 0.0, 5.0), (0.0, 0.0, 10.0), "Lower"))
    rig = armatures.make(
        Lower=((0.0, 0.0, 0.0), (0.0, 0.0, 5.0)), Upper=((0.0, 0.0, 5.0), (0.0, 0.0, 10.0), "Lower"), **more
    )
    middle = handles.MIDDLE[0]
    steps.add_group(obj, "Lower", range(middle))
    steps.add_group(obj, "Upper", range(middle, len(obj.data.vertices)))
    obj.modifiers.new("Armature", 'ARMATURE').object = rig
    rigs.bend(rig, 60.0, "Upper")
    for name in bones:
        rig.pose.bones[name].location = (1.0, 0.0, 0.0)
    meshes.activate(obj)
    update()
    return obj


def test_groups_that_grab_makes_are_no_skin_of_bones_called_the_same():
    obj = skinned("Handle", "Region", "Pin")
    before = meshes.seen(obj)
    assert bpy.ops.meanvalue.grab(vertex=TOP[0], size=0.2, offset=(0.0, 0.0, 0.0)) == {'FINISHED'}
    update()
    assert np.abs(meshes.seen(obj) - before).max() < 1e-5
    made = {group.name for group in obj.vertex_groups} - {"Lower", "Upper"}
    assert made and made.isdisjoint({"Handle", "Region", "Pin"})


@pytest.mark.parametrize("pin", [False, True])
def test_a_handle_may_be_called_as_a_bone(pin):
    obj = skinned("Tip")
    before = meshes.seen(obj)
    selected = np.zeros(len(obj.data.vertices), bool)
    selected[list(TOP)] = True
    obj.data.vertices.foreach_set("select", selected)
    bpy.ops.object.mode_set(mode='EDIT')
    assert bpy.ops.meanvalue.add_handle(pin=pin, name="Tip") == {'FINISHED'}
    bpy.ops.object.mode_set(mode='OBJECT')
    update()
    assert np.abs(meshes.seen(obj) - before).max() < 1e-5
    assert obj.meanvalue.handles[-1].name == "Tip"


def test_a_control_that_another_handle_follows_stays_until_that_one_goes():
    obj, control = handles.tube(live=True)
    bottom = obj.meanvalue.handles["Bottom"]
    bottom.follows = 'CONTROL'
    bottom.control = control
    update()
    name = control.name
    meshes.activate(obj)
    obj.meanvalue.active_handle = obj.meanvalue.handles.find("Top")
    assert bpy.ops.meanvalue.remove_handle() == {'FINISHED'}
    assert obj.meanvalue.handles["Bottom"].control == bpy.data.objects[name]
    assert bpy.ops.meanvalue.remove_handle() == {'FINISHED'}
    assert name not in bpy.data.objects


@pytest.mark.parametrize("keep", ["SHAPE_KEY", "REST"])
def test_finish_leaves_no_second_pose_on_linked_duplicates(keep):
    obj, control = handles.tube(live=True)
    move(control, (0.0, 1.0, 0.0))
    pose = shown(obj).copy()
    other = meshes.duplicate(obj, linked=True)
    steps.run(obj, "finish", keep=keep)
    update()
    assert not other.meanvalue.live and not any(handle.control for handle in other.meanvalue.handles)
    assert np.abs(meshes.seen(obj) - pose).max() < 1e-5
    assert np.abs(meshes.seen(other) - pose).max() < 1e-5


@pytest.mark.parametrize("keep", ["SHAPE_KEY", "REST"])
def test_finish_is_refused_where_another_object_poses_the_same_mesh(keep):
    obj, control = handles.tube(live=True)
    move(control, (0.0, 1.0, 0.0))
    other = meshes.duplicate(obj, linked=True)
    meshes.activate(other)
    before = snapshot(obj), snapshot(other)
    with pytest.raises(RuntimeError, match=r"poses the same mesh by its own handles.*single user"):
        bpy.ops.meanvalue.finish(keep=keep)
    for was, now in zip(before, (snapshot(obj), snapshot(other)), strict=True):
        assert_same(was, now)
    bpy.ops.object.make_single_user(object=True, obdata=True)
    assert bpy.ops.meanvalue.finish(keep=keep) == {'FINISHED'}
    update()
    move(control, (0.0, 1.0, 0.0))
    assert obj.meanvalue.live and len(obj.meanvalue.handles) == 2
    assert np.abs(shown(obj)[list(TOP)] - handles.rest(obj)[list(TOP)] - [0.0, 2.0, 0.0]).max() < 1e-4
