# SPDX-License-Identifier: GPL-3.0-or-later
"""The tube of handles.py on an armature of two bones, one above the other."""

import math

from mathutils import Quaternion

from . import armatures, handles, meshes

LOWER = [vertex for vertex in range(handles.RINGS * handles.SEGMENTS) if vertex < 8 * handles.SEGMENTS]
UPPER = [vertex for vertex in range(handles.RINGS * handles.SEGMENTS) if vertex >= 8 * handles.SEGMENTS]


def tube(live=False):
    """(object, armature object) with the result key there; the tube's control is its handle's."""
    obj, _control = handles.tube(live=True)
    obj.meanvalue.live = live
    height = max(vertex.co.z for vertex in obj.data.vertices)
    middle = (0.0, 0.0, 0.5 * height)
    rig = armatures.make(Lower=((0.0, 0.0, 0.0), middle), Upper=(middle, (0.0, 0.0, height), "Lower"))
    for name, members in (("Lower", LOWER), ("Upper", UPPER)):
        obj.vertex_groups.new(name=name).add(members, 1.0, 'REPLACE')
    obj.modifiers.new("Armature", 'ARMATURE').object = rig
    meshes.activate(obj)
    handles.update()
    return obj, rig


def bend(rig, degrees):
    """Turns the upper bone, as the artist does in Pose Mode; the caller updates."""
    rig.pose.bones["Upper"].rotation_quaternion = Quaternion((1.0, 0.0, 0.0), math.radians(degrees))
