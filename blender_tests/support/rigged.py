# SPDX-License-Identifier: GPL-3.0-or-later
"""The tube of handles.py on an armature of two bones, one above the other."""

import math

import bpy
from mathutils import Quaternion

from . import handles, meshes

LOWER = [vertex for vertex in range(handles.RINGS * handles.SEGMENTS) if vertex < 8 * handles.SEGMENTS]
UPPER = [vertex for vertex in range(handles.RINGS * handles.SEGMENTS) if vertex >= 8 * handles.SEGMENTS]


def tube(live=False):
    """(object, armature object) with the result key there; the tube's control is its line's."""
    obj, _control = handles.tube(live=True)
    obj.meanvalue.live = live
    height = max(vertex.co.z for vertex in obj.data.vertices)
    data = bpy.data.armatures.new("Rig")
    rig = bpy.data.objects.new("Rig", data)
    bpy.context.collection.objects.link(rig)
    meshes.activate(rig)
    bpy.ops.object.mode_set(mode='EDIT')
    lower, upper = data.edit_bones.new("Lower"), data.edit_bones.new("Upper")
    lower.head, lower.tail = (0.0, 0.0, 0.0), (0.0, 0.0, 0.5 * height)
    upper.head, upper.tail = lower.tail, (0.0, 0.0, height)
    upper.parent = lower
    bpy.ops.object.mode_set(mode='OBJECT')
    for name, members in (("Lower", LOWER), ("Upper", UPPER)):
        obj.vertex_groups.new(name=name).add(members, 1.0, 'REPLACE')
    obj.modifiers.new("Armature", 'ARMATURE').object = rig
    meshes.activate(obj)
    handles.update()
    return obj, rig


def bend(rig, degrees):
    """Turns the upper bone, as the artist does in Pose Mode; the caller updates."""
    rig.pose.bones["Upper"].rotation_quaternion = Quaternion((1.0, 0.0, 0.0), math.radians(degrees))
