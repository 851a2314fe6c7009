# SPDX-License-Identifier: GPL-3.0-or-later
"""Controls that were made for a mesh go with it when the artist deletes it.

Names alone are kept: undo and redo bring the same ones back.
"""

import bpy

from ...scene import actions

_made_for = {}  # name of a control: name of the mesh object that it was made for


def made(control, obj):
    _made_for[control.name] = obj.name


def note():
    """Takes down whose controls there are; what is known of deleted ones is kept for redo."""
    for obj in bpy.data.objects:
        if obj.type == 'MESH':
            for handle in obj.meanvalue.handles:
                if handle.made_control and handle.control is not None:
                    made(handle.control, obj)


def forget():
    _made_for.clear()


def are_there():
    """Whether a mesh with controls is gone, or called otherwise. Cheap."""
    objects = bpy.data.objects
    return any(mesh not in objects and control in objects for control, mesh in _made_for.items())


def remove():
    """Removes the controls of meshes that are gone. Not in a handler."""
    note()
    for name, mesh in list(_made_for.items()):
        control = bpy.data.objects.get(name)
        if control is None or mesh in bpy.data.objects:
            continue
        del _made_for[name]
        if control.type == 'EMPTY' and control.parent is None and not _is_used(control):
            actions.remove_action(control)
            bpy.data.objects.remove(control)
            _made_for[name] = mesh  # redo brings it back


def _is_used(control):
    """By anything but what it is in: as a parent, by constraints, drivers, modifiers, handles."""
    users = bpy.data.user_map(subset={control})[control]
    return any(not isinstance(user, (bpy.types.Collection, bpy.types.Scene)) for user in users)
