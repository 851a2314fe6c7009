# SPDX-License-Identifier: GPL-3.0-or-later
"""What you see is what you pose: handles of meshes behind armatures, lattices and other shape keys."""

import math

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from support import meshes, rigs, steps
from support.posed_rigs import all_at_once, dual_quaternions, lattice, linear, other_keys
from support.rigs import BOTTOM, MIDDLE, NEAR, OFFSET, RESULT, TOP, update

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


# -- controls: reset, chosen, bones that deform; and on objects that are scaled ----------------------------------------


def test_reset_puts_the_control_to_where_the_handle_is_seen():
    obj, _ = linear()
    before = rigs.seen(obj)
    control = rigs.held(obj, "Part", MIDDLE)
    rigs.move_in_world(control, OFFSET)
    steps.run(obj, "reset_handles")
    update()
    assert np.allclose(control.matrix_world.translation, before[MIDDLE].mean(axis=0), atol=1e-4)
    assert np.abs(rigs.seen(obj) - before).max() < 1e-3


def test_another_control_takes_a_posed_handle_over_where_it_is_seen():
    obj, _armature = linear()
    rigs.move_in_world(rigs.held(obj, "Part", MIDDLE), OFFSET)
    before = rigs.seen(obj)
    other = meshes.new_object("Other")
    other.location = (3.0, 2.0, 1.0)
    update()
    obj.meanvalue.handles["Part"].control = other
    update()
    assert np.abs(rigs.seen(obj) - before).max() < 1e-3
    rigs.move_in_world(other, OFFSET)
    assert np.abs(rigs.seen(obj)[MIDDLE] - before[MIDDLE] - OFFSET).max() < 3.0 * NEAR * rigs.size(obj)


def test_apply_pose_keeps_what_is_seen():
    obj, _armature = linear()
    control = rigs.held(obj, "Part", MIDDLE)
    rigs.move_in_world(control, OFFSET)
    before = rigs.seen(obj)
    steps.run(obj, "apply_pose")
    update()
    update()
    assert np.abs(rigs.seen(obj) - before).max() < 1e-3
    rigs.move_in_world(control, OFFSET)
    assert np.abs(rigs.seen(obj)[MIDDLE] - before[MIDDLE] - OFFSET).max() < NEAR * rigs.size(obj)


@pytest.mark.parametrize("live", [True, False])
def test_a_control_of_before_the_bend_goes_along_before_it_is_moved(live):
    """The rig was bent with Live off."""
    obj, armature = rigs.arm()
    control = rigs.held(obj, "Part", TOP, live=False)
    rigs.bend(armature, 90.0)
    meshes.activate(obj)
    if live:
        obj.meanvalue.live = True
        update()
        update()
    else:
        assert bpy.ops.meanvalue.bind() == {'FINISHED'}
        steps.solve()
    update()
    before = rigs.seen(obj)[TOP]
    assert np.allclose(control.matrix_world.translation, before.mean(axis=0), atol=1e-3)
    assert np.abs(steps.key_positions(obj, RESULT) - steps.key_positions(obj, "Basis")).max() < 1e-3
    rigs.move_in_world(control, OFFSET)
    if not live:
        steps.solve()
    assert np.abs(rigs.seen(obj)[TOP] - before - OFFSET).max() < NEAR * rigs.size(obj)


def bone_carries(part):
    """(object, armature, where the part is seen, n x 3): the bone that deforms the part carries its handle too."""
    obj, armature = rigs.arm()
    rigs.held(obj, "Part", part)
    handle = obj.meanvalue.handles["Part"]
    handle.control, handle.bone = armature, "Lower"
    update()
    return obj, armature, rigs.seen(obj)[part]


@pytest.mark.parametrize("part", [TOP, MIDDLE], ids=["all of it", "in part"])
def test_a_bone_that_deforms_its_handle_moves_it_once(part):
    obj, armature, before = bone_carries(part)
    expected = turned_with_bone(armature, before, 50.0)
    assert np.abs(rigs.seen(obj)[part] - expected).max() < NEAR * rigs.size(obj)


def test_choosing_a_control_and_then_its_bone_moves_nothing():
    obj, armature = rigs.arm()
    rigs.held(obj, "Part", MIDDLE)
    handle = obj.meanvalue.handles["Part"]
    before = steps.key_positions(obj, RESULT)
    handle.control = armature  # far from the handle
    assert np.abs(steps.key_positions(obj, RESULT) - before).max() < NEAR * rigs.size(obj)
    handle.bone = "Lower"
    update()
    assert np.abs(steps.key_positions(obj, RESULT) - before).max() < NEAR * rigs.size(obj)


def test_a_bone_that_deforms_its_handle_in_part_is_reset():
    """What is asked of it moves with it."""
    obj, armature, before = bone_carries(MIDDLE)
    rest = armature.pose.bones["Lower"].matrix.copy()
    rigs.bend(armature, 50.0)
    steps.run(obj, "reset_handles")
    update()
    assert np.abs(np.array(armature.pose.bones["Lower"].matrix) - np.array(rest)).max() < 1e-4
    assert np.abs(rigs.seen(obj)[MIDDLE] - before).max() < NEAR * rigs.size(obj)


def test_reset_ends_where_nothing_comes_nearer(part, monkeypatch):
    (obj, _armature), puts = rigs.posed_arm(), []
    monkeypatch.setattr(part("posing.bridge.control_places"), "put", lambda *each: puts.append(each))
    rigs.move_in_world(obj.meanvalue.handles["Top"].control, (1.0, 0.0, 0.0))
    steps.run(obj, "reset_handles")
    assert len(puts) == 1


def turned_with_bone(armature, points, degrees):
    rest = armature.pose.bones["Lower"].matrix.copy()
    rigs.bend(armature, degrees)
    turn = np.array(armature.pose.bones["Lower"].matrix @ rest.inverted())
    return points @ turn[:3, :3].T + turn[:3, 3]


@pytest.mark.parametrize("is_scaled_first", [True, False])
def test_a_turn_on_an_object_scaled_unevenly_does_not_shear(is_scaled_first):
    """Where it was scaled after the control was made, from the next Reset on."""
    obj = meshes.tube(rigs.RINGS, rigs.SEGMENTS, "Arm")
    rigs.pin(obj, "Bottom", BOTTOM)
    control = None if is_scaled_first else rigs.handle(obj, "Top", TOP)
    obj.scale = (1.0, 3.0, 0.5)
    obj.rotation_euler = (0.3, 0.2, 0.1)
    update()
    control = control or rigs.handle(obj, "Top", TOP)
    if not is_scaled_first:
        steps.run(obj, "reset_handles")
        assert np.abs(rigs.seen(obj) - steps.key_positions(obj, "Basis")).max() < NEAR * rigs.size(obj)
    world = np.array(obj.matrix_world)
    before = (rigs.seen(obj) @ world[:3, :3].T + world[:3, 3])[TOP]
    control.rotation_mode = 'XYZ'
    control.rotation_euler = (0.0, 0.0, math.radians(60.0))
    update()
    after = (rigs.seen(obj) @ world[:3, :3].T + world[:3, 3])[TOP]
    lengths = [np.linalg.norm(points[:, None] - points[None], axis=2) for points in (before, after)]
    assert np.abs(before - after).max() > 1.0
    assert np.abs(lengths[0] - lengths[1]).max() < NEAR * rigs.size(obj)
    axes = np.array(control.matrix_world.to_3x3())
    gram = axes.T @ axes
    assert np.abs(gram - np.diag(np.diag(gram))).max() < 1e-5  # the control itself is not sheared either
