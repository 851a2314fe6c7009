# SPDX-License-Identifier: GPL-3.0-or-later
"""Controls of meshes on rigs: reset, chosen, bones that deform; and on objects that are scaled."""

import math

import bpy
import numpy as np
import pytest
from support import meshes, rigs, steps
from support.posed_rigs import linear
from support.rigs import BOTTOM, MIDDLE, TOP, update

RESULT = "Mean-Value"
OFFSET = (0.7, -0.4, 0.9)

#: Of the mesh's size.
NEAR = 1e-4


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
