# SPDX-License-Identifier: GPL-3.0-or-later
"""A kept pose that a bone drives, by a driver of Blender's own."""

import math

import bpy
import numpy as np
import pytest
from support import handles, rigs, steps
from support.handles import move


def corrected(has_keyframes=False, degrees=60.0):
    """(object, armature object) with the bone bent and a pose kept for that."""
    obj, rig = rigs.posed_arm()
    rigs.bend(rig, degrees)
    move(obj.meanvalue.handles["Top"].control, (0.3, 0.0, 0.0))
    if has_keyframes:
        obj.meanvalue.handles["Top"].control.keyframe_insert("location")
    bpy.ops.meanvalue.keep_pose(name="Bent")
    return obj, rig


def value_at(obj, rig, degrees, name="Bent"):
    rigs.bend(rig, degrees)
    return obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.shape_keys.key_blocks[name].value


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
    obj.data.shape_keys.key_blocks["Bent"].driver_add("value").driver.expression = "0.25"
    with steps.refused("'Bent' is driven already"):
        bpy.ops.meanvalue.drive_by_bone()
    assert obj.data.shape_keys.animation_data.drivers[0].driver.expression == "0.25"


def test_bone_axis_and_angle_can_be_given():
    obj, rig = corrected()
    assert bpy.ops.meanvalue.drive_by_bone(bone="Lower", axis='X', angle=math.radians(20.0)) == {'FINISHED'}
    assert value_at(obj, rig, 10.0) == pytest.approx(0.5, abs=1e-4)
    obj.data.shape_keys.key_blocks["Bent"].driver_remove("value")
    with steps.refused("no bone 'Nowhere'"):
        bpy.ops.meanvalue.drive_by_bone(bone="Nowhere")


def test_refused_where_no_bone_is_turned():
    obj, _rig = corrected(degrees=0.0)
    for given in ({}, {"angle": 0.5}):  # no bone is taken by chance
        with steps.refused("No bone is turned"):
            bpy.ops.meanvalue.drive_by_bone(**given)
    assert not obj.data.shape_keys.animation_data


def test_a_second_pose_of_the_bone_leaves_the_first_alone():
    obj, rig = corrected()
    bpy.ops.meanvalue.drive_by_bone()
    wanted = {60.0: ((1.0, 0.0), rigs.seen(obj))}
    rigs.bend(rig, 120.0)
    move(obj.meanvalue.handles["Top"].control, (0.0, 0.4, 0.0))
    wanted[120.0] = (0.0, 1.0), rigs.seen(obj)
    bpy.ops.meanvalue.keep_pose(name="Far")
    for degrees, (values, seen) in wanted.items():
        assert [value_at(obj, rig, degrees, name) for name in ("Bent", "Far")] == pytest.approx(values, abs=1e-6)
        assert np.abs(rigs.seen(obj) - seen).max() < 1e-2
    bpy.ops.meanvalue.drive_by_bone(remove=True)
    assert not [each for part in (obj, obj.data.shape_keys) for each in part.animation_data.drivers if not each.mute]
    assert "Drive" not in "".join(obj.keys())


def test_what_an_artist_animates_masks_or_names_stays_so():
    obj, rig = corrected()
    keys, obj["Drive by Pose?"] = obj.data.shape_keys.key_blocks, "mine"
    keys["Bent"].vertex_group, keys["Bent"].name = obj.vertex_groups.new(name="None").name, "Fist"
    for degrees, name in ((120.0, "Far"), (0.0, "Bent"), (90.0, "Near")):
        rigs.bend(rig, degrees)
        move(obj.meanvalue.handles["Top"].control, (0.0, 0.4, 0.0))
        seen = rigs.seen(obj)
        bpy.ops.meanvalue.keep_pose(name=name)
        bpy.context.scene.frame_set(bpy.context.scene.frame_current + 1)
        assert np.abs(rigs.seen(obj) - seen).max() < 1e-2
        keys["Far"].keyframe_insert("value")
    obj.active_shape_key_index, mark = keys.find("Fist"), keys["Fist"].slider_min
    bpy.ops.meanvalue.drive_by_bone()  # this and "Near": "Bent" is for the rest, and took no other's pose with its name
    assert obj["Drive by Pose?"] and keys["Fist"].slider_min == mark and len(keys.id_data.animation_data.drivers) == 2


def test_each_of_many_poses_is_on_at_its_own_and_what_is_renamed_or_reloaded_goes_on(tmp_path):
    obj, rig = rigs.arm()
    obj.shape_key_add(name="Basis")

    def turned(upper):
        rig.pose.bones[0].rotation_mode = 'XYZ'
        rig.pose.bones[0].rotation_euler = np.radians(upper)
        handles.update()
        return [key.value for key in obj.data.shape_keys.key_blocks[1:]]

    poses = np.array([(60, 0, 0), (0, 0, -70), (0, 60, 0), (90, 0, 60)])
    for pose in poses:
        obj.shape_key_add().data[0].co.x += 1.0
        obj.active_shape_key_index += 1
        turned(pose)
        bpy.ops.meanvalue.drive_by_bone()
    drivers = [*obj.animation_data.drivers, *obj.data.shape_keys.animation_data.drivers]
    assert all(curve.driver.is_simple_expression and curve.driver.is_valid for curve in drivers)
    for each in (obj, obj.data, rig, rig.data, rig.pose.bones[0], *obj.data.shape_keys.key_blocks[1:]):
        each.name += " renamed"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "poses.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "poses.blend"))
    obj = bpy.data.objects["Arm renamed"]
    rig = obj.modifiers[0].object
    np.testing.assert_allclose([turned(each) for each in (np.zeros(3), *poses)], np.eye(5)[:, 1:], atol=1e-6)
    np.testing.assert_allclose([turned(each + 0.3) for each in poses], np.eye(4), atol=1e-3)
    way = np.array([turned((1.0 - share) * poses[0] + share * poses[1]) for share in np.linspace(0.0, 1.0, 30)])
    assert way.min() >= 0.0 and way.sum(axis=1).max() <= 1.0 + 1e-6
    assert np.diff(way[:, 0]).max() < 1e-6 and np.diff(way[:, 1]).min() > -1e-6
