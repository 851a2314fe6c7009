# SPDX-License-Identifier: GPL-3.0-or-later
"""Which mesh follows an object, remembered: every operator asks in its poll(), several dozen times a redraw."""

import bpy

from ... import compat
from . import controls

_known = {}  # session key of an object: name of the mesh object that follows it, or ""


def mesh_moved_by(control):
    """A mesh object of the scene with a handle that follows `control`, the one it belongs to first; or None."""
    owner = controls.owner_of(control)
    if owner is not None:
        return owner
    key = compat.session_key(control)
    name = _known.get(key)
    if name == "":  # Blender would go through all objects to find none
        return None
    if name is not None and _follows(bpy.data.objects.get(name), control):
        return bpy.data.objects[name]
    found = next((obj for obj in bpy.context.view_layer.objects if _follows(obj, control)), None)
    _known[key] = found.name if found is not None else ""
    return found


def _follows(obj, control):
    is_mesh = obj is not None and obj.type == 'MESH'
    return is_mesh and any(handle.control == control for handle in obj.meanvalue.handles)


def forget():
    _known.clear()
