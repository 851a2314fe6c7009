# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking to shape keys: how many, how near, and what becomes of those that were there."""

import json

import bpy
import numpy as np
import pytest
from support import meshes, steps
from support.baking import FRAMES, animated_tube, bake, curves, played, rest, rows, save
from support.snapshot import assert_same, snapshot

TIMES = range(1, FRAMES + 1)


@pytest.fixture
def solved(tmp_path):
    """(f, n, 3) that a point cache of the animated tube has; the object is called Tube."""
    obj, _control = animated_tube()
    save(tmp_path)
    bake()
    shapes = rows(tmp_path / "meanvalue_cache" / "scene" / "Tube.pc2")
    assert bpy.ops.meanvalue.unbake() == {'FINISHED'}
    assert len(obj.modifiers) == 0
    return shapes


def tube():
    return bpy.data.objects["Tube"]


def baked_names(obj):
    return json.loads(obj.meanvalue.baked.keys)


def off(shapes, solved):
    return float(np.linalg.norm(shapes - solved, axis=-1).max())


def test_a_key_for_every_frame_plays_what_was_solved_and_is_replaced(solved, tmp_path):
    bake(target='SHAPE_KEYS', tolerance_share=0)
    assert len(baked_names(tube())) == FRAMES
    assert off(played(tube(), TIMES), solved) < 1e-5
    assert not list((tmp_path / "meanvalue_cache" / "scene").glob("*.part*"))
    bake(target='SHAPE_KEYS', tolerance_share=0, samples=2)
    assert baked_names(tube())[:3] == ["Bake 0001", "Bake 0001.5", "Bake 0002"]
    assert len(tube().data.shape_keys.key_blocks) == 2 * FRAMES
    assert off(played(tube(), TIMES), solved) < 5e-3  # solved with more steps
    two = played(tube(), [1, 1.125, 1.5])
    assert off(two[1], two[0] + (two[2] - two[0]) / 4) < 1e-5
    bake()
    assert tube().data.shape_keys is None
    assert np.array_equal(played(tube(), TIMES), solved)


@pytest.mark.parametrize("share", [0.1, 0.5, 5.0])
def test_adaptive_keys_are_within_the_tolerance_at_every_frame(solved, share):
    diagonal = float(np.linalg.norm(np.ptp(rest(tube()), axis=0)))
    bake(target='SHAPE_KEYS', tolerance_share=share)
    assert off(played(tube(), TIMES), solved) <= share / 100 * diagonal + 1e-5
    assert share < 0.5 or len(baked_names(tube())) < FRAMES


def test_values_cross_fade_linearly(solved):
    bake(target='SHAPE_KEYS', tolerance_share=0)
    keys = tube().data.shape_keys
    for frame in (1.0, 2.5, 5.0, 9.75, 12.0, 30.0, -5.0):
        steps.go_to(frame)
        values = [keys.key_blocks[name].value for name in baked_names(tube())]
        assert sum(values) == pytest.approx(1.0)
        assert sum(value > 0 for value in values) <= 2
    for curve in curves(keys):
        assert {point.interpolation for point in curve.keyframe_points} == {'LINEAR'}
        assert len(curve.keyframe_points) <= 3


def test_absolute_keys_are_refused_and_those_of_older_bakes_taken_back(solved):
    bake(target='SHAPE_KEYS', tolerance_share=0)
    keys = tube().data.shape_keys
    keys.use_relative = False
    with steps.refused("absolute"):
        bpy.ops.meanvalue.bake(target='SHAPE_KEYS')
    keys.eval_time = 3.0
    smile = tube().shape_key_add(name="Smile", from_mix=False)
    assert bpy.ops.meanvalue.unbake() == {'FINISHED'}
    assert keys.use_relative and [key.name for key in keys.key_blocks] == ["Basis", smile.name]


def test_sub_frames_have_their_names_and_times(solved):
    bake(target='SHAPE_KEYS', tolerance_share=0, samples=2, frame_range='OWN', frame_start=-1, frame_end=1)
    names = baked_names(tube())
    assert names == [f"Bake {frame}" for frame in ("-0001", "-0000.5", "0000", "0000.5", "0001")]
    assert all(name in tube().data.shape_keys.key_blocks for name in names)


def test_remove_bake_leaves_the_artists_keys_and_curves(solved):
    obj = tube()
    obj.shape_key_add(name="Basis", from_mix=False)
    smile = obj.shape_key_add(name="Smile", from_mix=False)
    smile.data[0].co.x += 1.0
    smile.keyframe_insert("value", frame=3)
    obj.active_shape_key_index = 1
    before = snapshot(obj)
    bake(target='SHAPE_KEYS')
    assert len(obj.data.shape_keys.key_blocks) > 3
    assert bpy.ops.meanvalue.unbake() == {'FINISHED'}
    assert_same(before, snapshot(obj))
    assert [curve.data_path for curve in curves(obj.data.shape_keys)] == ['key_blocks["Smile"].value']


def test_a_mesh_without_keys_is_without_keys_again_in_an_unsaved_file():
    obj, control = animated_tube()
    control.animation_data_clear()
    assert obj.data.shape_keys is None
    bake(target='SHAPE_KEYS', frame_range='OWN', frame_start=1, frame_end=3)
    assert bpy.ops.meanvalue.unbake() == {'FINISHED'}
    assert obj.data.shape_keys is None
    assert not [action for action in bpy.data.actions if action.users]


def test_a_shared_mesh_takes_the_keys_of_one_object(solved):
    obj = tube()
    bake(target='SHAPE_KEYS')
    bpy.ops.object.duplicate(linked=True)
    copy = bpy.context.object
    copy.meanvalue.baked.property_unset("target")
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    meshes.activate(copy)
    with steps.refused(f"shared with '{obj.name}'", "point cache"):
        bpy.ops.meanvalue.bake(target='SHAPE_KEYS')


def test_settings_of_the_object_count_where_nothing_is_given(solved):
    settings = tube().meanvalue.bake
    settings.target, settings.tolerance_share, settings.frame_range = 'SHAPE_KEYS', 0, 'OWN'
    settings.frame_start, settings.frame_end = 2, 3
    bake()
    assert baked_names(tube()) == ["Bake 0002", "Bake 0003"]
    bake(frame_end=2)
    assert baked_names(tube()) == ["Bake 0002"]


def test_each_bake_goes_into_the_same_action(tmp_path):
    """From 4.4 on the object and its keys may have slots of one action."""
    obj, _control = animated_tube()
    obj.keyframe_insert("location", frame=1)
    save(tmp_path)
    bake(target='SHAPE_KEYS')
    keys = obj.data.shape_keys
    if hasattr(bpy.types.Action, "slots"):
        obj.animation_data.action = keys.animation_data.action
        obj.keyframe_insert("location", frame=1)

    def counted():
        slots = getattr(obj.data.shape_keys.animation_data.action, "slots", ())
        return len(bpy.data.actions), len(slots)

    before = counted()
    for _again in range(2):
        bake(target='SHAPE_KEYS')
        assert counted() == before
        assert played(obj, [1])[0].tolist() != played(obj, [6])[0].tolist()
