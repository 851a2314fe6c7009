# SPDX-License-Identifier: GPL-3.0-or-later
"""Pins the mesh around a vertex, or lets go of the pin there: Grab with Shift."""

from ... import ids, wording
from ...errors import SceneError
from ...scene import rig_space, vertex_groups
from . import controls, new_handles, region
from .grip import handle_at, near_vertices


def toggle(obj, vertex, size):
    """Returns (message, [notes]). The pin holds as much as a new handle of that size. @throws SceneError."""
    index = handle_at(obj, vertex)
    if index is not None:
        return _let_go(obj, index), []
    members = near_vertices(obj, vertex, region.HANDLE_SHARE * region.radius(obj, size))
    is_posed = new_handles.is_posed(obj, members)
    if is_posed:
        rig_space.measure(obj)  # throws before anything is changed
    handle = new_handles.add_handle(obj, members, new_name=ids.PIN_GROUP)
    if is_posed:
        new_handles.make_handle(obj, handle, members, new_handles.PIN_COLOR)
        handle.is_pin = True
    else:
        new_handles.make_pin(handle)
    obj.update_tag()
    notes = []
    if obj.meanvalue.roi_group and not region.current_mask(obj)[vertex]:
        notes.append("Nothing moves here anyway: it is outside the region")
    return f"Pin '{handle.name}' holds {wording.vertices(len(members))}; Shift-click it again to let go", notes


def pressed_vertex(obj, pressed):
    """The vertex of a Pressed: of a control the first one of its handle; -1 for none."""
    if not pressed.handle:
        return pressed.vertex
    members = vertex_groups.members(obj, [pressed.handle])[pressed.handle]
    return int(members[0]) if len(members) else -1


def _let_go(obj, index):
    handle = obj.meanvalue.handles[index]
    if handle.follows != 'REST' and not handle.is_pin:
        raise SceneError(
            f"'{handle.name}' is a handle: drag it, or leave it where it is, since it holds the mesh like a pin. To "
            "remove it, click it in the list and press -"
        )
    name = handle.name
    controls.remove_handle(obj, index)
    return f"Pin '{name}' is let go"
