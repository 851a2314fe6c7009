# SPDX-License-Identifier: GPL-3.0-or-later
"""Pose Like: Own Rig. The poses of an animated rig that differ most become muted shape keys, and examples."""

import bpy
import numpy as np
import pytest
from support import libraries, meshes, rigs, steps
from support.handles import BOTTOM, TOP

#: Frame, and how far the elbow is bent.
BENDS = {1: 0, 20: 110, 40: -90, 60: 0}


@pytest.fixture
def arm():
    """(mesh object, armature object): an arm whose elbow bends forth and back."""
    obj, armature = rigs.arm()
    animate(armature, BENDS)
    meshes.activate(obj)
    return obj, armature


def animate(armature, bends):
    for frame, degrees in bends.items():
        rigs.bend(armature, degrees)
        armature.pose.bones["Lower"].keyframe_insert("rotation_euler", frame=frame)
    bpy.context.scene.frame_set(1)


def poses(obj):
    return [key for key in obj.data.shape_keys.key_blocks if key.name.startswith("Rig Pose")]


def seen_at(obj, frame):
    bpy.context.scene.frame_set(frame)
    return rigs.seen(obj)


def test_the_poses_that_differ_most_are_kept_muted(arm):
    obj, _ = arm
    bpy.context.scene.frame_set(7)
    before = rigs.seen(obj)
    assert bpy.ops.meanvalue.sample_rig_poses(count=2) == {'FINISHED'}
    assert bpy.context.scene.frame_current == 7
    assert obj.meanvalue.pose_like == 'RIG'
    assert [key.name for key in poses(obj)] == ["Rig Pose 20", "Rig Pose 40"]
    assert all(key.mute and key.value == 0.0 for key in poses(obj))
    np.testing.assert_allclose(rigs.seen(obj), before, atol=1e-6)
    for key, frame in zip(poses(obj), (20, 40), strict=True):
        np.testing.assert_allclose(steps.key_positions(obj, key.name), seen_at(obj, frame), atol=1e-5)
    assert bpy.ops.meanvalue.sample_rig_poses(count=5) == {'FINISHED'}
    assert len(poses(obj)) == 5 and not any(".0" in key.name for key in poses(obj))


def test_keys_of_the_artist_s_own_are_left_alone(arm):
    obj, _ = arm
    obj.shape_key_add(name="Basis", from_mix=False)
    own = [obj.shape_key_add(name=name, from_mix=False).name for name in ("Rig Pose 20", "Rig Posed by hand")]
    obj.data.shape_keys.key_blocks[own[1]].mute = True
    assert bpy.ops.meanvalue.sample_rig_poses(count=2) == {'FINISHED'}
    assert bpy.ops.meanvalue.sample_rig_poses(count=2) == {'FINISHED'}
    assert {key.name for key in poses(obj)} == {*own, "Rig Pose 20.001", "Rig Pose 40"}


def test_the_rig_may_be_linked(arm, tmp_path):
    obj, armature = arm
    obj.modifiers["Armature"].object = libraries.linked(tmp_path, armature, "objects")
    bpy.data.objects.remove(armature)
    bpy.context.view_layer.update()
    steps.run(obj, "sample_rig_poses", count=2)
    assert [key.name for key in poses(obj)] == ["Rig Pose 20", "Rig Pose 40"]


def test_what_makes_vertices_and_what_is_posed_does_not_count(arm):
    obj, _ = arm
    obj.modifiers.new("Subdivision", 'SUBSURF')
    rigs.pin(obj, "Bottom", BOTTOM)
    control = rigs.handle(obj, "Top", TOP)
    rigs.move_in_world(control, (0.0, 1.0, 0.0))
    assert bpy.ops.meanvalue.sample_rig_poses(count=1) == {'FINISHED'}
    (key,) = poses(obj)
    obj.modifiers["Subdivision"].show_viewport = False
    obj.meanvalue.live = False
    obj.data.shape_keys.key_blocks[obj.meanvalue.result_key].mute = True
    np.testing.assert_allclose(steps.key_positions(obj, key.name), seen_at(obj, int(key.name.split()[-1])), atol=1e-5)


def test_handles_bend_the_arm_as_its_rig_does(arm):
    obj, armature = arm
    rigs.bend(armature, 70)
    truth = rigs.seen(obj)
    steps.add_key(obj, "Asked", truth).mute = True
    rigs.bend(armature, 0)
    rigs.pin(obj, "Bottom", BOTTOM)
    rigs.pin(obj, "Top", TOP)

    def error():
        assert bpy.ops.meanvalue.solve_from_key(key="Asked") == {'FINISHED'}
        return np.linalg.norm(steps.key_positions(obj, "Mean-Value") - truth, axis=1).mean()

    alone = error()
    assert bpy.ops.meanvalue.sample_rig_poses() == {'FINISHED'}
    assert error() < 0.7 * alone
    shape = steps.key_positions(obj, poses(obj)[0].name)
    obj.meanvalue.pose_like = 'SHAPE_KEYS'
    with steps.refused("no shape key"):
        bpy.ops.meanvalue.bind()
    obj.meanvalue.pose_like = 'RIG'
    before = error()
    poses(obj)[0].data.foreach_set("co", (0.5 * (shape + steps.key_positions(obj, "Basis"))).ravel())
    obj.data.update_tag()
    bpy.context.view_layer.update()
    assert error() != before, "an edited pose counts"


def test_what_is_missing_is_said(arm):
    obj, armature = arm
    obj.meanvalue.pose_like = 'RIG'
    rigs.pin(obj, "Top", TOP)
    with steps.refused("Press Sample Rig Poses"):
        bpy.ops.meanvalue.bind()
    action, armature.animation_data.action = armature.animation_data.action, None
    rigs.bend(armature, 0)
    with steps.refused("'Arm' keeps its shape", "Animate its rig"):
        bpy.ops.meanvalue.sample_rig_poses()
    armature.animation_data.action = action
    obj.modifiers["Armature"].show_viewport = False
    assert not bpy.ops.meanvalue.sample_rig_poses.poll()
    with steps.refused("follows no rig"):
        bpy.ops.meanvalue.sample_rig_poses()
    obj.modifiers["Armature"].show_viewport = True
    obj.shape_key_add(name="Basis")
    obj.data.shape_keys.use_relative = False
    with steps.refused("absolute"):
        bpy.ops.meanvalue.sample_rig_poses()
    assert not poses(obj)


def test_the_rig_may_turn_the_whole_and_one_undo_takes_all_back(arm):
    obj, armature = arm
    armature.keyframe_insert("location", frame=1)
    armature.location, armature.rotation_euler = (5.0, 2.0, 1.0), (0.0, 1.0, 2.0)
    armature.keyframe_insert("location", frame=60)
    armature.keyframe_insert("rotation_euler", frame=60)
    bpy.ops.ed.undo_push(message="before")
    assert bpy.ops.meanvalue.sample_rig_poses(count=2) == {'FINISHED'}
    frames = [int(key.name.split()[-1]) for key in poses(obj)]
    np.testing.assert_allclose(frames, (20, 40), atol=1)
    bpy.ops.ed.undo_push(message="after")
    bpy.ops.ed.undo()
    obj = bpy.data.objects["Arm"]
    assert obj.data.shape_keys is None
    assert obj.meanvalue.pose_like == 'NOTHING'
