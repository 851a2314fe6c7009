# SPDX-License-Identifier: GPL-3.0-or-later
"""Controls that were made for a mesh: which the artist has deleted, and those that go with a mesh that was deleted.

Our Empties bear a mark, too, since Blender may put a new object where a deleted one was.
"""

import bpy

from ... import compat, ids
from ...scene import actions

_made_for = {}  # session key of a control that was seen in a collection: that of the mesh that it was made for


def made(control, obj):
    control.meanvalue.is_control = True
    _made_for[compat.session_key(control)] = compat.session_key(obj)


def is_deleted(handle):
    """Whether the artist has deleted the control that was made for `handle`: nothing else uses it any more, but it was
    seen in a collection. So none that was appended with its mesh, or whose collection was unlinked; and none with
    animation, which would be lost. On any thread."""
    control = handle.control
    if control is None or not handle.made_control:
        return handle.made_control
    key = compat.session_key(control)
    if control.users > 1 + (handle.attached == control):
        if key not in _made_for:
            _made_for[key] = compat.session_key(handle.id_data)
        return False
    return key in _made_for and not actions.is_animated(control)


def note():
    """After loading or undo: takes down whose controls there are."""
    for obj in bpy.data.objects:
        if obj.type == 'MESH':
            for handle in obj.meanvalue.handles:
                if handle.made_control and handle.control is not None:
                    handle.control.meanvalue.is_control = True
                    is_deleted(handle)


def forget():
    _made_for.clear()


def found():
    """[control] of meshes that are gone, after objects went."""
    there = {compat.session_key(obj): obj for obj in bpy.data.objects} if _made_for else {}
    for control in _made_for.keys() - there.keys():
        del _made_for[control]
    return [there[control] for control, mesh in _made_for.items() if mesh not in there]


def remove():
    """Removes the controls of meshes that are gone, but for those with animation, and what more than collections uses:
    children, constraints, drivers, modifiers, handles. Not in a handler."""
    for control in found():
        is_ours = control.type == 'EMPTY' and control.meanvalue.is_control and control.parent is None
        if is_ours and not actions.is_animated(control):
            users = bpy.data.user_map(subset={control})[control]
            if all(isinstance(user, (bpy.types.Collection, bpy.types.Scene)) for user in users):
                delete(control)


def delete(control):
    """With its action, and the collection that was made for controls if it is the last in there."""
    homes = [each for each in control.users_collection if ids.CONTROLS_MARK in each]
    actions.remove_action(control)
    bpy.data.objects.remove(control)
    for collection in homes:
        if not collection.objects and not collection.children:
            bpy.data.collections.remove(collection)
