# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking to an armature: its bones show what was found, of whatever moves the mesh, and go again."""

import bpy
import numpy as np
import pytest
from support import rigs
from support.baking import FRAMES, animated_tube, played, rest
from support.snapshot import assert_same, snapshot


def of_a_rig():
    obj, rig = rigs.arm()
    obj.parent, rig.location = rig, (1.0, 2.0, 3.0)
    for frame in (1, FRAMES):
        rigs.bend(rig, 5.0 * frame)
        rig.pose.bones["Lower"].keyframe_insert("rotation_euler", frame=frame)
    return obj


@pytest.mark.parametrize("source", [lambda: animated_tube(live=True)[0], of_a_rig])
def test_bones_show_what_was_found_and_go_again(part, monkeypatch, tmp_path, source):
    obj, bones, found, times = source(), part("baking.bridge.bones"), [], range(1, FRAMES + 1)
    name, places, play = obj.name, np.pad(rest(obj), ((0, 0), (0, 1)), constant_values=1.0), bones.play
    monkeypatch.setattr(bones, "play", lambda parts, *given: (found.append(given[0]), play(parts, *given))[1])
    size, shown = np.linalg.norm(np.ptp(places, axis=0)), played(obj, times)
    before = snapshot(obj, {"settings", "keys"}), [each.show_viewport for each in obj.modifiers], repr(obj.parent)
    bpy.ops.ed.undo_push(message="Before")
    assert bpy.ops.meanvalue.bake('EXEC_DEFAULT', True, target='ARMATURE', bones=8) == {'FINISHED'}
    weights = np.where(found[0].weights < 1e-3, 0.0, found[0].weights)
    exact = np.einsum("nb,fbij,nj->fni", weights, found[0].transforms[:, :, :3], places) / weights.sum(axis=1)[:, None]
    assert np.linalg.norm(played(obj, times) - exact, axis=2).max() < 1e-5 * size
    assert np.linalg.norm(exact - shown, axis=2).max() < 0.02 * size < np.ptp(shown, axis=0).max()
    bpy.ops.ed.undo()
    assert_same(before[0], snapshot(bpy.data.objects[name], {"settings", "keys"}))
    bpy.ops.ed.redo()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "bones.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "bones.blend"))
    assert bpy.ops.meanvalue.unbake() == {'FINISHED'}
    assert_same(before[0], snapshot(obj := bpy.data.objects[name], {"settings", "keys"}))
    assert [each.show_viewport for each in obj.modifiers] == before[1] and len(bpy.data.armatures) == len(before[1])
    assert np.abs(played(obj, times) - shown).max() < 1e-4 * size and repr(obj.parent) == before[2]


def test_a_linked_duplicate_keeps_its_weights():
    obj = of_a_rig()
    bpy.ops.meanvalue.bake('EXEC_DEFAULT', True, target='ARMATURE', bones=8)
    shown = played(obj, [FRAMES])
    bpy.ops.object.duplicate(linked=True)
    bpy.ops.meanvalue.unbake()
    assert np.abs(played(obj, [FRAMES]) - shown).max() < 1e-5 and obj.parent == obj.meanvalue.baked.rig
