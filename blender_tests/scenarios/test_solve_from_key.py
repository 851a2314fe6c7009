# SPDX-License-Identifier: GPL-3.0-or-later
"""Solve from Shape Key: the places of handles are those of a key, once."""

import bpy
import numpy as np
import pytest
from support import handles, meshes, steps
from support.handles import BOTTOM, TOP, update
from support.snapshot import assert_same, snapshot


@pytest.fixture
def posed():
    """A tube without handles, with two vertex groups, and a key in which one of them was moved."""
    obj = meshes.tube(handles.RINGS, handles.SEGMENTS)
    steps.add_group(obj, "feet", BOTTOM)
    steps.add_group(obj, "hand", TOP)
    steps.add_pose_key(obj)
    steps.move(obj, TOP, (1.0, 0.5, 0.0))
    return obj


def pin(obj, *groups):
    for group in groups:
        assert bpy.ops.meanvalue.add_handle(group=group, pin=True) == {'FINISHED'}


def test_pins_go_where_the_key_has_them_and_the_key_is_not_added(posed):
    pin(posed, "hand", "feet")
    assert bpy.ops.meanvalue.solve_from_key() == {'FINISHED'}
    keys, shown = posed.data.shape_keys.key_blocks, meshes.seen(posed)
    assert (keys["Pose"].value, keys["Mean-Value"].value) == (0.0, 1.0)
    assert np.abs(shown[TOP] - steps.key_positions(posed, "Pose")[TOP]).max() < 1e-5
    middle = slice(8 * handles.SEGMENTS, 9 * handles.SEGMENTS)
    assert np.abs(shown - steps.key_positions(posed, "Basis"))[middle].max() > 0.1


@pytest.mark.parametrize(
    "groups, key, text", [(["hand", "feet"], "Smile", "no shape key 'Smile'"), ([], "", "no handles yet")]
)
def test_what_is_missing_is_told_before_anything_is_changed(posed, groups, key, text):
    pin(posed, *groups)
    before = snapshot(posed)
    with steps.refused(text):
        bpy.ops.meanvalue.solve_from_key(key=key)
    assert_same(before, snapshot(posed))


def test_nothing_follows_afterwards():
    obj, control = handles.tube()
    meshes.activate(obj)
    steps.add_pose_key(obj)
    steps.move(obj, TOP, (0.0, 1.0, 0.0))
    assert bpy.ops.meanvalue.solve_from_key() == {'FINISHED'}
    assert not obj.meanvalue.live
    solved = meshes.seen(obj)
    steps.move(obj, TOP, (0.0, 1.0, 0.0))
    control.location.x += 1.0
    update()
    assert np.array_equal(meshes.seen(obj), solved)
    assert np.abs(solved[TOP] - steps.key_positions(obj, "Basis")[TOP] - (0.0, 1.0, 0.0)).max() < 1e-5
