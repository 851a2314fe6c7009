# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes on rigs, and where linear blend and dual quaternion skinning have their vertices by the book."""

import math

import numpy as np

from . import armatures, meshes, steps
from .handles import BOTTOM, MIDDLE, RINGS, SEGMENTS, TOP, update  # noqa: F401  for tests

LENGTH, ELBOW = 9.6, 4.8
RESULT = "Mean-Value"
#: What controls are moved by; of the mesh's size, what is near.
OFFSET, NEAR = (0.7, -0.4, 0.9), 1e-4
#: Vertices within this distance of the elbow are shared by both bones.
SHARE = 1.5


def arm(volume=False, name="Arm"):
    """(mesh object, armature object): a tube along z with a bone in each half; volume: dual quaternions."""
    obj = meshes.tube(RINGS, SEGMENTS, name)
    obj.meanvalue.stretch = True  # handles go farther than an arm reaches
    elbow = (0.0, 0.0, ELBOW)
    armature = armatures.make(Upper=((0.0, 0.0, 0.0), elbow), Lower=(elbow, (0.0, 0.0, LENGTH), "Upper"))
    meshes.activate(obj)
    share = lower_share(obj)
    for bone, weights in (("Upper", 1.0 - share), ("Lower", share)):
        steps.add_weights(obj, bone, weights)
    modifier = obj.modifiers.new("Armature", 'ARMATURE')
    modifier.object = armature
    modifier.use_deform_preserve_volume = volume
    update()
    return obj, armature


def posed_arm(live=True):
    """(mesh object, armature object): arm() with a pin at its bottom and a handle at its top."""
    obj, armature = arm()
    held(obj, "Top", TOP, live)
    meshes.activate(obj)
    return obj, armature


def lower_share(obj):
    """n: how much of each vertex the lower bone carries. Multiples of 1/64, which no storage rounds."""
    height = np.array([vertex.co.z for vertex in obj.data.vertices])
    return np.round(np.clip((height - ELBOW + SHARE) / (2.0 * SHARE), 0.0, 1.0) * 64.0) / 64.0


def bend(armature, degrees, bone="Lower"):
    pose_bone = armature.pose.bones[bone]
    pose_bone.rotation_mode = 'XYZ'
    pose_bone.rotation_euler = (math.radians(degrees), 0.0, 0.0)
    update()
    update()  # controls that went along have their place after this one


def skinned(obj, armature, points, volume=False):
    """n x 3: where skinning by the book has the n x 3 points of the key, from the bones' matrices."""
    turn = np.array(armature.pose.bones["Lower"].matrix @ armature.data.bones["Lower"].matrix_local.inverted())
    share = lower_share(obj)[:, None]
    if not volume:
        return (1.0 - share) * points + share * (points @ turn[:3, :3].T + turn[:3, 3])
    pairs = zip(share[:, 0], points, strict=True)
    return np.array([_by_dual_quaternions(turn, float(each), point) for each, point in pairs])


def _by_dual_quaternions(turn, share, point):
    """Kavan et al. 2007, for two bones of which one is at rest."""
    from mathutils import Matrix, Quaternion, Vector

    matrix = Matrix(turn.tolist())
    real = matrix.to_quaternion()
    dual = 0.5 * (Quaternion((0.0, *matrix.translation)) @ real)
    sign = -1.0 if real.w < 0.0 else 1.0
    real = np.array((1.0 - share, 0.0, 0.0, 0.0)) + sign * share * np.array(real)
    dual = sign * share * np.array(dual)
    length = float(np.linalg.norm(real))
    real, dual = Quaternion(real / length), Quaternion(dual / length)
    offset = 2.0 * (dual @ real.conjugated())
    return np.array(real @ Vector(point.tolist())) + np.array(offset)[1:]


def seen(obj):
    """n x 3 float64: where the vertices of the mesh are seen, in the object's space."""
    return meshes.seen(obj)[: len(obj.data.vertices)].astype(np.float64)


def size(obj):
    return float(np.linalg.norm(np.ptp([vertex.co for vertex in obj.data.vertices], axis=0)))


def handle(obj, name, indices, live=True):
    """The control of a new handle of these vertices; Live comes on with the first."""
    if name not in obj.vertex_groups:
        steps.add_group(obj, name, indices)
    steps.run(obj, "add_handle", group=name, live=live)
    update()
    return obj.meanvalue.handles[name].control


def held(obj, name, indices, live=True):
    """As handle(), of a mesh whose bottom is pinned for it."""
    pin(obj, "Bottom", BOTTOM)
    return handle(obj, name, indices, live)


def pin(obj, name, indices):
    meshes.activate(obj)
    steps.add_handle(obj, name, indices, pin=True)
    update()


def move_in_world(control, offset):
    world = control.matrix_world.copy()
    world.translation = [a + b for a, b in zip(world.translation, offset, strict=True)]
    control.matrix_world = world
    update()
