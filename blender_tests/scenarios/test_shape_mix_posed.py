# SPDX-License-Identifier: GPL-3.0-or-later
"""A mix below an armature: the armature poses the mixed shape, live and baked."""

import bpy
import numpy as np
import pytest
from support import armatures, meshes
from support.mixed_limbs import DIAGONAL, bake, bending, rest, set_value, shown

TURN = np.radians(70.0)
SHIFT = (2.0, -1.0, 3.0)


@pytest.fixture
def rigged():
    """(object, pose bone): half of the limb follows the bone."""
    obj = bending()
    rig = armatures.make(Bone=((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    meshes.activate(obj)
    group = obj.vertex_groups.new(name="Bone")
    group.add(np.flatnonzero(follows()).tolist(), 1.0, 'REPLACE')
    modifier = obj.modifiers.new("Armature", 'ARMATURE')
    modifier.object = rig
    return obj, rig.pose.bones["Bone"]


def follows():
    """(n,) bool."""
    longest = np.ptp(rest(), axis=0).argmax()
    return rest()[:, longest] > rest()[:, longest].mean()


def pose(bone):
    bone.rotation_mode = 'XYZ'
    bone.rotation_euler = (0.0, TURN, 0.3)
    bone.location = SHIFT
    bpy.context.view_layer.update()


def posed(bone, shape):
    """(n, 3): what the armature makes of the shape that it is given."""
    matrix = np.array(bone.matrix @ bone.bone.matrix_local.inverted())
    return np.where(follows()[:, None], shape @ matrix[:3, :3].T + matrix[:3, 3], shape)


@pytest.mark.parametrize("is_baked", [False, True], ids=["live", "baked"])
def test_an_armature_poses_the_mixed_shape(rigged, is_baked):
    obj, bone = rigged
    obj.meanvalue.mix.is_on = True
    if is_baked:
        bake(obj)
    set_value(obj, "Bend", 0.5)
    mixed = shown(obj)
    pose(bone)
    np.testing.assert_allclose(shown(obj), posed(bone, mixed), atol=1e-5 * DIAGONAL)
    assert np.abs(shown(obj) - mixed).max() > 0.1 * DIAGONAL
    set_value(obj, "Bend", 0.0)
    set_value(obj, "Bend", 0.5)  # mixed while it is posed
    np.testing.assert_allclose(shown(obj), posed(bone, mixed), atol=1e-4 * DIAGONAL)
