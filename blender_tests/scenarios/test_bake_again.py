# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking again, in part, after it was stopped; taking it back."""

import bpy
import numpy as np
import pytest
from support import steps
from support.baking import FRAMES, animated_tube, bake, curves, played, rows, save
from support.snapshot import assert_same, snapshot

# -- again, and back -------------------------------------------------------------------------------------------------


def test_nothing_changed_nothing_to_do(saved):
    obj, control, path = saved
    bake()
    stamp = path.stat().st_mtime_ns
    bake()
    assert path.stat().st_mtime_ns == stamp
    obj.modifiers.clear()
    bake()
    assert path.stat().st_mtime_ns == stamp
    assert obj.modifiers[0].type == 'MESH_CACHE'
    curves(control)[0].keyframe_points[1].co.y += 0.5
    bake()
    assert path.stat().st_mtime_ns > stamp
    assert len(obj.modifiers) == 1


def test_files_of_one_folder_keep_their_own_caches(tmp_path, part):
    obj, control = animated_tube()
    save(tmp_path, "first.blend")
    bake()
    path = tmp_path / "meanvalue_cache" / "first" / "Tube.pc2"
    first = path.read_bytes()
    save(tmp_path, "second.blend")
    curves(control)[0].keyframe_points[1].co.y += 0.5
    bake()
    assert path.read_bytes() == first != (tmp_path / "meanvalue_cache" / "second" / "Tube.pc2").read_bytes()
    # Another file that is called as the first, with an object that is called so.
    save(tmp_path, "first.blend")
    part("baking.bridge.preparing")._made.clear()
    obj.meanvalue.bake.mark = ""
    with steps.refused("will be replaced"):
        bpy.ops.meanvalue.bake()
    assert path.read_bytes() == first
    bake(confirm=True)
    curves(control)[0].keyframe_points[1].co.y += 0.5
    bake()
    assert path.read_bytes() != first


def test_remove_bake_takes_back_what_bake_made(tmp_path):
    obj, _control = animated_tube(live=True)
    save(tmp_path)
    obj.meanvalue.bake.mark = "stays"
    bpy.context.scene.frame_set(5)
    before, shape = snapshot(obj, without=("keys",)), steps.key_positions(obj, "Mean-Value")
    assert obj.meanvalue.live
    bake()
    assert not obj.meanvalue.live
    assert obj.data.shape_keys.key_blocks["Mean-Value"].mute
    assert np.array_equal(played(obj, range(1, FRAMES + 1)), rows(tmp_path / "meanvalue_cache" / "scene" / "Tube.pc2"))
    bpy.context.scene.frame_set(5)
    assert bpy.ops.meanvalue.unbake() == {"FINISHED"}
    assert_same(before, snapshot(obj, without=("keys",)))
    key = obj.data.shape_keys.key_blocks["Mean-Value"]
    assert not key.mute and np.abs(steps.key_positions(obj, "Mean-Value") - shape).max() < 1e-3  # live, so solved anew
    assert (tmp_path / "meanvalue_cache" / "scene" / "Tube.pc2").exists()
    assert not bpy.ops.meanvalue.unbake.poll()


@pytest.mark.parametrize("target", ['POINT_CACHE', 'SHAPE_KEYS'])
def test_the_bake_is_kept_and_the_handles_are_removed(tmp_path, target):
    obj, _control = animated_tube(live=True)
    path = save(tmp_path)
    bake(target=target)
    before = played(obj, range(1, FRAMES + 1))
    assert bpy.ops.meanvalue.unbake(keep_bake=True) == {'FINISHED'}
    assert not obj.meanvalue.handles
    assert [each.name for each in bpy.data.objects if each.type == 'EMPTY'] == []
    assert not bpy.ops.meanvalue.unbake.poll()
    bpy.ops.wm.save_mainfile()
    bpy.ops.wm.open_mainfile(filepath=str(path))
    assert np.array_equal(played(bpy.data.objects["Tube"], range(1, FRAMES + 1)), before)


def test_undo_takes_it_back_and_redo_plays_the_file(saved):
    _obj, _control, path = saved
    bpy.ops.ed.undo_push(message="before")
    bake()
    bpy.ops.ed.undo_push(message="baked")
    bpy.ops.ed.undo()
    obj = bpy.data.objects["Tube"]
    assert len(obj.modifiers) == 0
    assert obj.meanvalue.baked.target == ""
    bpy.ops.ed.redo()
    assert np.array_equal(played(bpy.data.objects["Tube"], [1, 7]), rows(path)[[0, 6]])


def test_posing_on_does_not_move_a_baked_mesh_twice(saved):
    obj, _control, path = saved
    bake(target="SHAPE_KEYS", tolerance_share=0)
    baked = played(obj, [1, 6])
    obj.meanvalue.live = True
    assert np.abs(played(obj, [1, 6]) - baked).max() < 1e-6
    obj.meanvalue.live = False
    assert bpy.ops.meanvalue.solve() == {"FINISHED"}
    assert np.abs(played(obj, [1, 6]) - baked).max() < 1e-6
    bake()
    assert np.array_equal(played(obj, [1, 6]), rows(path)[[0, 5]])
