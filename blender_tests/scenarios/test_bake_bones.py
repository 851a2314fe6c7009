# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking to an armature: its bones show what was found, of whatever moves the mesh, and go again."""

import bpy
import numpy as np
import pytest
from support import meshes, rigs, steps
from support.baking import FRAMES, animated_tube, played, rest
from support.snapshot import assert_same, snapshot

TIMES = range(1, FRAMES + 1)


def of_a_rig():
    obj, rig = rigs.arm()
    obj.parent, rig.location = rig, (1.0, 2.0, 3.0)
    for frame in (1, FRAMES):
        rigs.bend(rig, 5.0 * frame)
        rig.pose.bones["Lower"].keyframe_insert("rotation_euler", frame=frame)
    return obj


def of_a_simulation():
    obj = meshes.tube(24, 16, "Soft")
    settings = obj.modifiers.new("Softbody", 'SOFT_BODY').settings
    obj.modifiers[0].point_cache.frame_end = FRAMES
    steps.add_weights(obj, "Goal", 1.0 - rest(obj)[:, 2] / rest(obj)[:, 2].max())
    settings.vertex_group_goal, settings.goal_default = "Goal", 0.5
    for frame in (1, FRAMES):
        obj.rotation_euler = (0.05 * frame, 0.0, 0.0)
        obj.keyframe_insert("rotation_euler", frame=frame)
    meshes.activate(obj)
    return obj


def bake(**options):
    return bpy.ops.meanvalue.bake('EXEC_DEFAULT', True, **{"target": 'ARMATURE', "bones": 8, **options})


@pytest.mark.parametrize("source", [lambda: animated_tube(live=True)[0], of_a_rig, of_a_simulation])
def test_bones_show_what_was_found_and_go_again(part, monkeypatch, tmp_path, source):
    obj, bones, found, times = source(), part("baking.bridge.bones"), [], TIMES
    name, places, play = obj.name, np.pad(rest(obj), ((0, 0), (0, 1)), constant_values=1.0), bones.play
    monkeypatch.setattr(bones, "play", lambda parts, *given: (found.append(given[0]), play(parts, *given))[1])
    size, shown = np.linalg.norm(np.ptp(places, axis=0)), played(obj, times)
    without = {"settings", "keys", "modifiers"}
    before = snapshot(obj, without), [(each.type, each.show_viewport) for each in obj.modifiers], repr(obj.parent)
    bpy.ops.ed.undo_push(message="Before")
    assert bake() == {'FINISHED'}
    weights = np.where(found[0].weights < 1e-3, 0.0, found[0].weights)
    exact = np.einsum("nb,fbij,nj->fni", weights, found[0].transforms[:, :, :3], places) / weights.sum(axis=1)[:, None]
    assert np.linalg.norm(played(obj, times) - exact, axis=2).max() < 1e-5 * size
    assert np.linalg.norm(exact - shown, axis=2).max() < 0.02 * size < np.ptp(shown, axis=0).max()
    assert bpy.ops.meanvalue.select_problems(kind='BAKED') == {'FINISHED'}
    bpy.ops.object.mode_set(mode='OBJECT')
    off, selected = found[0].errors, [vertex.index for vertex in obj.data.vertices if vertex.select]
    assert selected == np.flatnonzero(off[bpy.context.scene.frame_current - 1] > 0.5 * off.max()).tolist() != []
    bpy.ops.ed.undo()
    assert_same(before[0], snapshot(bpy.data.objects[name], without))
    bpy.ops.ed.redo()
    hidden = [each for each in bpy.data.objects[name].modifiers if not each.show_viewport]
    for number, modifier in enumerate(hidden):
        modifier.name = f"Renamed {number}"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "bones.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "bones.blend"))
    assert bpy.ops.meanvalue.unbake() == {'FINISHED'}
    assert_same(before[0], snapshot(obj := bpy.data.objects[name], without))
    assert [(each.type, each.show_viewport) for each in obj.modifiers] == before[1]
    assert len(bpy.data.armatures) == (before[2] != "None")
    assert np.abs(played(obj, times) - shown).max() < 1e-4 * size and repr(obj.parent) == before[2]


def test_a_linked_duplicate_keeps_its_weights():
    obj = of_a_rig()
    bpy.ops.meanvalue.bake('EXEC_DEFAULT', True, target='ARMATURE', bones=8)
    shown = played(obj, [FRAMES])
    bpy.ops.object.duplicate(linked=True)
    bpy.ops.meanvalue.unbake()
    assert np.abs(played(obj, [FRAMES]) - shown).max() < 1e-5 and obj.parent == obj.meanvalue.baked.rig


def test_a_simulation_is_baked_from_its_beginning_and_not_over_its_bake():
    obj = of_a_simulation()
    bake(frame_range='OWN', frame_start=6, frame_end=FRAMES)
    shown = played(obj, TIMES[5:])
    with pytest.raises(RuntimeError, match="Press Remove Bake first"):
        bake()
    bpy.ops.meanvalue.unbake()
    assert np.abs(played(obj, TIMES)[5:] - shown).max() < 0.01 * np.ptp(shown, axis=0).max()


@pytest.mark.parametrize(("its_motion", "near"), [(True, 1e-3), (False, 4e-3)])
def test_an_armature_of_the_artists_plays_as_a_copy_and_with_its_own_motion(its_motion, near):
    obj = of_a_rig()
    rig, size, shown = obj.parent, np.linalg.norm(np.ptp(rest(obj), axis=0)), played(obj, TIMES)
    obj.meanvalue.bake.armature, action = rig, rig.animation_data.action
    before = snapshot(obj, {"settings", "keys"})
    assert bake(its_motion=its_motion) == {'FINISHED'}
    plays = obj.meanvalue.baked.rig
    assert plays != rig and not obj.modifiers["Armature"].show_viewport
    assert np.linalg.norm(played(obj, TIMES) - shown, axis=2).max() < near * size
    for bone in plays.data.bones:
        assert bone.matrix_local == rig.data.bones[bone.name].matrix_local and bone.name in obj.vertex_groups
    assert bpy.ops.meanvalue.unbake() == {'FINISHED'} and rig.animation_data.action == action
    assert np.abs(played(obj, TIMES) - shown).max() < 1e-5 * size
    assert_same(before, snapshot(obj, {"settings", "keys"}))
