# SPDX-License-Identifier: GPL-3.0-or-later
"""Armatures for tests."""

import bpy

from . import meshes


def make(**bones):
    """A new armature object, the active one and in Object Mode.

    bones: {name: (head, tail)}, or (head, tail, name of the parent); parents come before their children.
    """
    armature = meshes.new_object("Rig", bpy.data.armatures.new("Rig"))
    meshes.activate(armature)
    bpy.ops.object.mode_set(mode='EDIT')
    for name, (head, tail, *parents) in bones.items():
        bone = armature.data.edit_bones.new(name)
        bone.head, bone.tail = head, tail
        for parent in parents:
            bone.parent = armature.data.edit_bones[parent]
    bpy.ops.object.mode_set(mode='OBJECT')
    return armature
