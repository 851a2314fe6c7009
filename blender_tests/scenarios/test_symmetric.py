# SPDX-License-Identifier: GPL-3.0-or-later
"""Symmetric: one side's handles pose both sides of a mesh that is symmetric by itself."""

import bpy
import numpy as np
import pytest
from support import halves, meshes, steps
from support.halves import asymmetry, move, rest, shown, turn, update

SAME = 1e-6


@pytest.fixture
def live():
    obj, control = halves.whole()
    obj.meanvalue.symmetric = 'X'
    update()
    return obj, control


def test_what_is_done_on_one_side_is_done_on_the_other(live):
    obj, control = live
    for step in range(5):
        move(control, (0.1, 0.05, 0.1))
        turn(control, 0.1, step % 3)
        assert asymmetry(obj, shown(obj)) < SAME, step
    moved = shown(obj) - rest(obj)
    left = rest(obj)[:, 0] < -0.7
    assert left.any() and np.abs(moved[left]).min(axis=1).max() > 0.1
    centre = np.abs(rest(obj)[:, 0]) < 1e-6
    assert np.abs(shown(obj)[centre, 0]).max() < SAME


def test_a_key_that_turns_a_handle_across_the_plane_aside_does_not_squash_it():
    obj, _control = halves.whole(live=False)
    top = np.flatnonzero(rest(obj)[:, 2] > 1.5)
    steps.add_handle(obj, "Head", top.tolist(), pin=True)
    obj.meanvalue.symmetric = 'X'
    steps.add_key(obj, "Asked", 1.2 * rest(obj) @ [(0.6, 0.8, 0.0), (-0.8, 0.6, 0.0), (0.0, 0.0, 1.0)])
    steps.run(obj, "solve_from_key", key="Asked")
    np.testing.assert_allclose(shown(obj)[top], 1.2 * rest(obj)[top], atol=1e-4)


def test_off_only_one_side_moves_and_on_both_do_while_live():
    obj, control = halves.whole()
    move(control, (0.4, 0.2, 0.3))
    assert asymmetry(obj, shown(obj)) > 0.1
    obj.meanvalue.symmetric = 'X'
    update()
    move(control, (0.0, 0.0, 1e-3))
    assert asymmetry(obj, shown(obj)) < SAME
    obj.meanvalue.symmetric = 'NONE'
    update()
    move(control, (0.0, 0.0, -1e-3))
    assert asymmetry(obj, shown(obj)) > 0.1


@pytest.mark.parametrize("axis", [1, 2])
def test_other_axes(axis):
    obj, control = halves.whole(live=False)
    obj.meanvalue.symmetric = "XYZ"[axis]
    obj.meanvalue.handles[0].is_enabled = axis == 1  # a pin at the bottom would be one at the top too
    middle = (np.abs(rest(obj)[:, 0]) < 0.2) & (np.abs(rest(obj)[:, 2]) < 0.1)
    steps.add_handle(obj, "Middle", np.flatnonzero(middle).tolist(), pin=True)
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    move(control, (0.3, 0.2, 0.2))
    steps.solve()
    assert asymmetry(obj, shown(obj), axis) < SAME
    assert np.abs(shown(obj) - rest(obj)).max() > 0.2


def test_a_mesh_that_is_not_symmetric_is_told_in_numbers_and_shown():
    obj, _control = halves.whole(live=False)
    far = int(np.argmax(rest(obj)[:, 2]))
    for number in (steps.members(obj, "Top")[0], far):
        obj.data.vertices[number].co.z += 0.2
    obj.meanvalue.symmetric = 'X'
    meshes.activate(obj)
    with steps.refused(f"{len(obj.data.vertices):,} vertices", "Unpaired"):
        bpy.ops.meanvalue.bind()
    assert bpy.ops.meanvalue.select_problems(kind='UNPAIRED') == {'FINISHED'}
    assert obj.mode == 'EDIT'
    bpy.ops.object.mode_set(mode='OBJECT')
    flags = np.zeros(len(obj.data.vertices), bool)
    obj.data.vertices.foreach_get("select", flags)
    assert flags[steps.members(obj, "Top")[0]] and 1 < flags.sum() <= 4


def test_a_region_on_one_side_is_one_on_both():
    obj, control = halves.whole(live=False)
    obj.meanvalue.symmetric = 'X'
    steps.add_group(obj, "Side", np.flatnonzero(rest(obj)[:, 0] > 0.3).tolist())
    obj.meanvalue.roi_group = "Side"
    steps.run(obj, "bind")
    move(control, (0.3, 0.1, 0.2))
    meshes.activate(obj)
    steps.solve()
    assert asymmetry(obj, shown(obj)) < SAME
    moved = np.abs(shown(obj) - rest(obj)).max(axis=1)
    assert moved[np.abs(rest(obj)[:, 0]) < 0.3].max() == 0.0 and moved.max() > 0.2


def test_beside_a_mirror_modifier():
    """Half a body, symmetric to the front and back as well; the modifier's own axis is no matter."""
    obj, control = halves.half()
    obj.meanvalue.symmetric = 'Y'
    update()
    move(control, (0.1, 0.2, 0.3))
    assert asymmetry(obj, shown(obj), 1) < SAME
    assert np.abs(shown(obj)[halves.seam(obj), 0]).max() < SAME
    obj.meanvalue.symmetric = 'X'
    update()
    move(control, (0.0, 0.2, 0.0))
    assert np.abs(shown(obj)[halves.seam(obj), 0]).max() < SAME
