# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking again, in part, after it was stopped; taking it back."""

import bpy
import numpy as np
import pytest
from support import steps
from support.baking import FRAMES, animated_tube, bake, curves, played, rows, save, saved_tube
from support.snapshot import assert_same, snapshot


@pytest.fixture
def saved(tmp_path):
    """(object, control, path of its cache) of an animated tube in a saved file."""
    return saved_tube(tmp_path)


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


def test_a_part_is_baked_again(saved):
    _obj, control, path = saved
    bake()
    before = rows(path)
    curve = curves(control)[0]
    for point in curve.keyframe_points:
        point.co.y += 0.5
    curve.update()
    bake(use_part=True, part_start=4, part_end=6)
    after = rows(path)
    assert np.array_equal(after[[0, 1, 2, *range(6, FRAMES)]], before[[0, 1, 2, *range(6, FRAMES)]])
    assert np.abs(after[3:6] - before[3:6]).max() > 0.4
    bake()
    assert np.abs(rows(path) - before).max(axis=(1, 2)).min() > 0.4  # all of it, now


def test_a_part_is_baked_again_of_what_has_three_samples_a_frame(saved):
    _obj, _control, path = saved
    bake(samples=3)
    before = rows(path)
    bake(samples=3, use_part=True, part_start=4, part_end=6)
    assert np.abs(rows(path) - before).max() < 1e-6
    assert not list(path.parent.rglob("merged.pc2"))


def test_a_part_needs_the_cache_as_it_was(saved):
    with steps.refused("no point cache", "Part Only"):
        bpy.ops.meanvalue.bake(use_part=True, part_start=1, part_end=2)
    bake()
    with steps.refused("12 samples", "6 of"):
        bpy.ops.meanvalue.bake(step=2, use_part=True, part_start=1, part_end=2)
    with steps.refused("not in the range"):
        bpy.ops.meanvalue.bake(use_part=True, part_start=50, part_end=60)


def test_remove_bake_takes_back_what_bake_made(tmp_path):
    obj, _control = animated_tube(live=True)
    save(tmp_path)
    bpy.context.scene.frame_set(5)
    before, shape = snapshot(obj, without=("keys",)), steps.key_positions(obj, "Mean-Value")
    assert obj.meanvalue.live
    bake()
    assert not obj.meanvalue.live
    assert obj.data.shape_keys.key_blocks["Mean-Value"].mute
    assert np.array_equal(played(obj, range(1, FRAMES + 1)), rows(tmp_path / "meanvalue_cache" / "Tube.pc2"))
    bpy.context.scene.frame_set(5)
    assert bpy.ops.meanvalue.unbake() == {"FINISHED"}
    assert_same(before, snapshot(obj, without=("keys",)))
    key = obj.data.shape_keys.key_blocks["Mean-Value"]
    assert not key.mute and np.abs(steps.key_positions(obj, "Mean-Value") - shape).max() < 1e-3  # live, so solved anew
    assert (tmp_path / "meanvalue_cache" / "Tube.pc2").exists()
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
