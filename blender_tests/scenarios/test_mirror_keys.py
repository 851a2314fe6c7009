# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape keys of the other side, with their poses and drivers; and poses of bones that were renamed."""

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from support import armatures, handles, meshes, rigs, steps

ACROSS = np.array((1.0, 1.0, -1.0))


def winged():
    """(object, rig): a tube along z around the origin, a bone in each half, a driven key for a pose of the left."""
    obj = meshes.tube(33, 16, "Bird")
    obj.data.transform(Matrix.Translation((0.0, 0.0, -9.6)))
    rest = np.array([vertex.co for vertex in obj.data.vertices])
    rig = armatures.make(**{"Wing.L": ((0, 0, 0), (0, 0, 9.6)), "Wing.R": ((0, 0, 0), (0, 0, -9.6))})
    meshes.activate(obj)
    for bone, side in (("Wing.L", 1.0), ("Wing.R", -1.0)):
        steps.add_weights(obj, bone, np.clip(0.5 + side * rest[:, 2], 0.0, 1.0))
    obj.modifiers.new("Armature", 'ARMATURE').object, obj.meanvalue.symmetric = rig, 'Z'
    steps.add_key(obj, "Up.L", rest + np.outer(np.exp(-np.square(rest[:, 2] - 1.0)), (0.3, 0.1, 0.2)))
    obj.active_shape_key_index = 1
    rigs.bend(rig, 60.0, "Wing.L")
    bpy.ops.meanvalue.drive_by_bone()
    return obj, rig


def test_a_mirrored_key_is_exact_and_shows_at_the_mirrored_pose(tmp_path):
    obj, _rig = winged()
    rest, shape = handles.rest(obj), steps.key_positions(obj, "Up.L")
    twins = np.argmin(np.linalg.norm(rest[:, None] * ACROSS - rest, axis=2), axis=1)
    for does in ('MIRROR', 'MIRROR_ALL'):  # which updates it
        shape = 2.0 * shape - rest
        obj.data.shape_keys.key_blocks["Up.L"].data.foreach_set("co", shape.ravel())
        bpy.ops.meanvalue.drive_by_bone(does=does)
        assert np.abs(steps.key_positions(obj, "Up.R")[twins] * ACROSS - shape).max() < 1e-6 * rigs.size(obj)
    obj, seen = steps.reopened(obj, tmp_path / "wings.blend"), []
    rig = obj.modifiers[0].object
    for name, bone in (("Up.L", "Wing.L"), ("Up.R", "Wing.R")):
        bpy.ops.meanvalue.drive_by_bone(does='POSE', key=name)
        rig.pose.bones["Wing.R" if bone == "Wing.L" else "Wing.L"].matrix_basis = Matrix()
        seen.append(rigs.seen(obj))
        values = [key.value for key in obj.data.shape_keys.key_blocks[1:]]
        assert values == pytest.approx([float(name == each) for each in ("Up.L", "Up.R")], abs=1e-4)
    assert np.abs(seen[1][twins] * ACROSS - seen[0]).max() < 1e-5 * rigs.size(obj)


def test_poses_follow_bones_that_were_renamed():
    obj, rig = winged()
    rig.data.bones[0].name, rig.data.bones[1].name = "Arm", "Wing.L"  # which is that of the other one
    rigs.bend(rig, -70.0, "Arm")
    steps.add_key(obj, "Down", steps.key_positions(obj, "Up.L"))
    obj.active_shape_key_index = 2
    bpy.ops.meanvalue.drive_by_bone()
    for degrees, wanted in ((60.0, (1.0, 0.0)), (-70.0, (0.0, 1.0)), (0.0, (0.0, 0.0))):
        rigs.bend(rig, degrees, "Arm")
        assert [key.value for key in obj.data.shape_keys.key_blocks[1:]] == pytest.approx(wanted, abs=1e-4)
