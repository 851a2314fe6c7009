# SPDX-License-Identifier: GPL-3.0-or-later
"""The rigs that posing is tried on, each as an artist comes upon it: bent, in a lattice, with other keys at a value."""

import bpy

from . import meshes, rigs
from .rigs import update


def linear():
    obj, armature = rigs.arm()
    rigs.bend(armature, 90.0)
    return obj, armature


def dual_quaternions():
    obj, armature = rigs.arm(volume=True)
    rigs.bend(armature, 90.0)
    return obj, armature


def lattice(obj=None):
    obj = obj or meshes.tube(rigs.RINGS, rigs.SEGMENTS, "Arm")
    cage = meshes.new_object("Cage", bpy.data.lattices.new("Cage"))
    cage.data.points_u = cage.data.points_v = 2
    cage.data.points_w = 4
    cage.location, cage.scale = (0.0, 0.0, 4.8), (6.0, 6.0, 16.0)
    for point in cage.data.points:
        point.co_deform.x += 0.3 * point.co.z * point.co.z * 4.0
        point.co_deform.y += 0.2 * point.co.z
    obj.modifiers.new("Lattice", 'LATTICE').object = cage
    update()
    return obj, cage


def other_keys(obj=None):
    obj = obj or meshes.tube(rigs.RINGS, rigs.SEGMENTS, "Arm")
    obj.shape_key_add(name="Basis", from_mix=False)
    for name, axis in (("Thick", 0), ("Long", 2)):
        key = obj.shape_key_add(name=name, from_mix=False)
        for point in key.data:
            point.co[axis] *= 1.3
        key.value = 0.5
    update()
    return obj, None


def all_at_once():
    obj, armature = rigs.arm(volume=True)
    other_keys(obj)
    lattice(obj)
    rigs.bend(armature, 90.0)
    return obj, armature
