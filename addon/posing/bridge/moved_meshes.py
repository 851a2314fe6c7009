# SPDX-License-Identifier: GPL-3.0-or-later
"""Which mesh follows an object, remembered: every operator asks in its poll(), several dozen times a redraw."""

import bpy

from ... import compat
from . import controls

_known = {}  # session key of an object: name of the mesh object that follows it, or None


def mesh_moved_by(control):
    """As controls.mesh_moved_by(), which goes through all objects of the scene."""
    owner = controls.owner_of(control)
    if owner is not None:
        return owner
    key = compat.session_key(control)
    if key not in _known:
        found = controls.mesh_moved_by(control)
        _known[key] = found.name if found else None
        return found
    obj = bpy.data.objects.get(_known[key]) if _known[key] is not None else None
    if obj is None or any(handle.control == control for handle in obj.meanvalue.handles):
        return obj
    del _known[key]
    return mesh_moved_by(control)


def note(depsgraph):
    """Blender has evaluated the scene: unless objects were moved and nothing else, all may be different."""
    if any(not _is_only_moved(update) for update in depsgraph.updates):
        _known.clear()


def forget():
    _known.clear()


def _is_only_moved(update):
    return isinstance(update.id, bpy.types.Object) and not (update.is_updated_geometry or update.is_updated_shading)
