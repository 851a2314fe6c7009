# SPDX-License-Identifier: GPL-3.0-or-later
"""A kept pose that a bone drives, by a driver of Blender's own."""

import math

import bpy
import numpy as np
import pytest
from support import handles, rigs, steps
from support.handles import move


def corrected(has_keyframes=False):
    """(object, armature object) with the bone bent and a pose kept for that."""
    obj, rig = rigs.posed_arm()
    rigs.bend(rig, 60.0)
    move(obj.meanvalue.handles["Top"].control, (0.3, 0.0, 0.0))
    if has_keyframes:
        obj.meanvalue.handles["Top"].control.keyframe_insert("location")
    bpy.ops.meanvalue.keep_pose(name="Bent")
    return obj, rig


def value_at(obj, rig, degrees):
    rigs.bend(rig, degrees)
    return obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.shape_keys.key_blocks["Bent"].value


@pytest.mark.parametrize("has_keyframes", [False, True])
def test_off_at_rest_and_on_at_the_pose(has_keyframes):
    obj, rig = corrected(has_keyframes)
    posed = rigs.seen(obj)
    assert bpy.ops.meanvalue.drive_by_bone() == {'FINISHED'}
    for degrees, value in ((0.0, 0.0), (30.0, 0.5), (60.0, 1.0), (90.0, 1.0), (-60.0, 0.0)):
        assert value_at(obj, rig, degrees) == pytest.approx(value, abs=1e-4)
        handles.update()
        left = obj.data.shape_keys.key_blocks["Mean-Value"].value
        assert left == pytest.approx(1.0 - has_keyframes * value, abs=1e-4)
        assert has_keyframes or np.abs(handles.shown(obj) - handles.rest(obj)).max() < 1e-3  # the bone alone poses it
    rigs.bend(rig, 60.0)
    assert np.abs(rigs.seen(obj) - posed).max() < 1e-2


def test_a_driver_that_is_there_stays():
    obj, _rig = corrected()
    driver = obj.data.shape_keys.key_blocks["Bent"].driver_add("value").driver
    driver.expression = "0.25"
    with steps.refused("'Bent' is driven already"):
        bpy.ops.meanvalue.drive_by_bone()
    assert obj.data.shape_keys.animation_data.drivers[0].driver.expression == "0.25"


def test_bone_axis_and_angle_can_be_given():
    obj, rig = corrected()
    call = bpy.ops.meanvalue.drive_by_bone
    assert call(bone="Lower", axis='X', angle=math.radians(20.0)) == {'FINISHED'}
    assert value_at(obj, rig, 10.0) == pytest.approx(0.5, abs=1e-4)
    obj.data.shape_keys.key_blocks["Bent"].driver_remove("value")
    with steps.refused("no bone 'Nowhere'"):
        call(bone="Nowhere")


def test_refused_where_no_bone_is_turned():
    obj, rig = corrected()
    rigs.bend(rig, 0.0)
    for given in ({}, {"angle": 0.5}):  # no bone is taken by chance
        with steps.refused("No bone is turned"):
            bpy.ops.meanvalue.drive_by_bone(**given)
    assert not obj.data.shape_keys.animation_data
