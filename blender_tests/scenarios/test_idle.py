# SPDX-License-Identifier: GPL-3.0-or-later
"""Where nothing follows and nothing is shown, scenes cost nothing more with the add-on."""

import sys

import bpy
import pytest
from support import handles, libraries, meshes, steps
from support.handles import TOP, follows


def animated(count):
    """So many mesh objects that move and whose shape keys are animated, and an active Empty."""
    for number in range(count):
        obj = meshes.grid()
        obj.keyframe_insert("location", frame=1)
        obj.location.x = number + 1.0
        obj.keyframe_insert("location", frame=9)
        key = steps.add_pose_key(obj)
        key.keyframe_insert("value", frame=1)
    empty = bpy.data.objects.new("Empty", None)
    bpy.context.collection.objects.link(empty)
    bpy.context.view_layer.objects.active = empty
    bpy.context.scene.frame_set(1)


def calls_of(function):
    """How many functions are called in it, Python's and built-in ones."""
    calls = []
    sys.setprofile(lambda _frame, event, _argument: calls.append(event) if "call" in event else None)
    try:
        function()
    finally:
        sys.setprofile(None)
    return len(calls)


def play():
    for frame in range(2, 6):
        bpy.context.scene.frame_set(frame)
        bpy.context.view_layer.objects.active.location.y += 1.0
        bpy.context.view_layer.update()


def test_a_frame_of_a_scene_without_us_costs_the_same_for_any_number_of_meshes():
    counts = []
    for count in (3, 97):
        animated(count)
        counts.append(calls_of(play) / 4)
    assert counts[0] == counts[1] and counts[1] < 60, counts


@pytest.mark.parametrize("how", ["turned on", "made local", "undone"])
def test_what_becomes_live_is_noticed(how, tmp_path, part):
    obj, control = handles.tube(live=how != "turned on")
    handles.update()
    if how == "made local":
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "live.blend"), copy=True)
        bpy.data.batch_remove([obj, control])
        obj = next(
            each for each in libraries.load(tmp_path / "live.blend", "objects", link=True) if each.type == 'MESH'
        )
        handles.update()
    part("live.roll").forget()
    part("scene.object_model").clear()
    if how == "turned on":
        obj.meanvalue.live = True
    elif how == "made local":
        name = obj.name
        bpy.ops.object.make_local(type='ALL')
        obj = bpy.data.objects[name]
    else:
        part("registration").meanvalue_look_again()
    handles.update()
    handles.move(obj.meanvalue.handles["Top"].control, (1.0, 0.0, 0.0))
    assert follows(obj, (1.0, 0.0, 0.0), TOP)
