# SPDX-License-Identifier: GPL-3.0-or-later
"""What you see is what you pose: handles of meshes behind armatures, lattices and other shape keys."""

import numpy as np
import pytest
from mathutils import Matrix
from support import rigs, steps
from support.posed_rigs import all_at_once, dual_quaternions, lattice, linear, other_keys
from support.rigs import BOTTOM, MIDDLE, TOP, update

RESULT = "Mean-Value"
OFFSET = (0.7, -0.4, 0.9)

#: Of the mesh's size.
NEAR = 1e-4


ALL = pytest.mark.parametrize("make", [linear, dual_quaternions, lattice, other_keys, all_at_once])


@ALL
def test_the_control_is_where_the_handle_is_seen(make):
    obj, _ = make()
    before = rigs.seen(obj)
    rigs.pin(obj, "Bottom", BOTTOM)
    for name, indices in (("Top", TOP), ("Middle", MIDDLE)):
        control = rigs.handle(obj, name, indices)
        assert np.allclose(control.matrix_world.translation, before[indices].mean(axis=0), atol=NEAR * rigs.size(obj))
    assert np.abs(rigs.seen(obj) - before).max() < NEAR * rigs.size(obj)


@ALL
@pytest.mark.parametrize("part", [TOP, MIDDLE])
@pytest.mark.parametrize("live", [True, False])
def test_a_control_moves_what_is_seen_by_as_much(make, part, live):
    obj, _ = make()
    control = rigs.held(obj, "Part", part, live)
    before = rigs.seen(obj)
    rigs.move_in_world(control, OFFSET)
    if not live:
        steps.run(obj, "bind")
        steps.solve()
    moved = rigs.seen(obj)[part] - before[part]
    assert np.abs(moved - OFFSET).max() < NEAR * rigs.size(obj)
    assert np.abs(rigs.seen(obj)[BOTTOM] - before[BOTTOM]).max() < NEAR * rigs.size(obj)


@ALL
def test_a_control_turns_what_is_seen_about_itself(make):
    obj, _ = make()
    control = rigs.held(obj, "Part", MIDDLE)
    before = rigs.seen(obj)[MIDDLE]
    centre = np.array(control.matrix_world.translation)
    turn = Matrix.Rotation(0.6, 4, (0.2, 1.0, 0.4))
    control.matrix_world = Matrix.Translation(centre) @ turn @ Matrix.Translation(-centre) @ control.matrix_world
    update()
    expected = (before - centre) @ np.array(turn.to_3x3()).T + centre
    assert np.abs(rigs.seen(obj)[MIDDLE] - expected).max() < NEAR * rigs.size(obj)


@pytest.mark.parametrize("volume", [False, True])
def test_the_key_is_what_inverse_skinning_gives(volume):
    obj, armature = rigs.arm(volume)
    rigs.bend(armature, 90.0)
    control = rigs.held(obj, "Part", MIDDLE)
    rest = steps.key_positions(obj, "Basis").astype(np.float64)
    assert np.abs(rigs.skinned(obj, armature, rest, volume) - rigs.seen(obj)).max() < 1e-4
    rigs.move_in_world(control, OFFSET)
    shape = steps.key_positions(obj, RESULT).astype(np.float64)
    expected = rigs.skinned(obj, armature, rest, volume)[MIDDLE] + OFFSET
    assert np.abs(rigs.skinned(obj, armature, shape, volume)[MIDDLE] - expected).max() < NEAR * rigs.size(obj)


@ALL
def test_a_rig_that_moves_changes_no_key(make):
    obj, armature = make()
    rigs.pin(obj, "Bottom", BOTTOM)
    controls = [rigs.handle(obj, name, part) for name, part in (("Middle", MIDDLE), ("Top", TOP))]
    for control in controls:
        rigs.move_in_world(control, OFFSET)
    shape = steps.key_positions(obj, RESULT)
    if armature is not None and armature.type == 'ARMATURE':
        rigs.bend(armature, 0.0)
        rigs.bend(armature, -40.0)
    elif armature is not None:
        armature.data.points[0].co_deform.x += 0.5
    else:
        obj.data.shape_keys.key_blocks["Long"].value = 0.1
    update()
    update()
    assert np.array_equal(steps.key_positions(obj, RESULT), shape)


def test_the_control_goes_along_with_the_rig():
    obj, armature = rigs.arm()
    control = rigs.held(obj, "Top", TOP)
    rigs.bend(armature, 90.0)
    assert np.allclose(control.matrix_world.translation, rigs.seen(obj)[TOP].mean(axis=0), atol=1e-4)
    assert tuple(control.location) == pytest.approx((0.0, 0.0, 9.6))
    rigs.bend(armature, 0.0)
    assert np.allclose(control.matrix_world.translation, (0.0, 0.0, 9.6), atol=1e-4)


def test_back_at_rest_the_key_is_a_corrective():
    """The elbow, pushed out where the arm is bent, is out by the inverse of its bones' share when it is straight."""
    obj, armature = rigs.arm()
    rigs.bend(armature, 90.0)
    rigs.pin(obj, "Bottom", BOTTOM)
    rigs.pin(obj, "End", TOP)
    control = rigs.handle(obj, "Elbow", MIDDLE)
    before = rigs.seen(obj)
    rigs.move_in_world(control, OFFSET)
    rest = steps.key_positions(obj, "Basis").astype(np.float64)
    turn = np.array(armature.pose.bones["Lower"].matrix @ armature.data.bones["Lower"].matrix_local.inverted())
    rigs.bend(armature, 0.0)
    share = rigs.lower_share(obj)[MIDDLE]
    expected = [np.linalg.solve((1.0 - each) * np.eye(3) + each * turn[:3, :3], np.array(OFFSET)) for each in share]
    assert np.abs(rigs.seen(obj)[MIDDLE] - rest[MIDDLE] - expected).max() < NEAR * rigs.size(obj)
    rigs.bend(armature, 90.0)
    assert np.abs(rigs.seen(obj)[MIDDLE] - before[MIDDLE] - OFFSET).max() < NEAR * rigs.size(obj)
