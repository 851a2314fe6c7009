# SPDX-License-Identifier: GPL-3.0-or-later
"""New handles with a control, and pins; which handle has a vertex."""

import numpy as np

from ... import ids, wording
from ...errors import SceneError
from ...scene import rig_space, shape_keys, vertex_groups, views
from . import controls, region

PIN_COLOR = (0.0, 0.45, 0.70)


def add_handle(obj, members, *, group="", new_name=""):
    """A new handle, the active one: of the vertex group `group`, or of a new one with the vertices `members`."""
    settings, made_group = obj.meanvalue, ""
    if not group:
        controls.remove_deleted(obj)
        made = vertex_groups.make(obj, new_name)
        made.add(members.tolist(), 1.0, 'REPLACE')
        group = made_group = made.name
    handle = settings.handles.add()
    handle.name, handle.made_group = group, made_group
    settings.active_handle = len(settings.handles) - 1
    return handle


def make_handle(obj, handle, members, color=None):
    """Gives a handle its control, at its vertices as they are shown. Returns the control."""
    carried = sum(other.follows == 'CONTROL' for other in obj.meanvalue.handles)
    handle.color = color or views.COLORS[carried % len(views.COLORS)]
    rest, shown = positions(obj, members)
    return controls.add_control(obj, handle, rest, shown)


def make_pin(handle):
    handle.follows = 'REST'
    handle.color = PIN_COLOR


def positions(obj, members):
    """(m x 3 in the rest shape, m x 3 as posed), float32."""
    rest = shape_keys.rest_positions(obj.data)[members]
    posed = shape_keys.posed_positions(obj)
    return rest, rest if posed is None else posed[members]


def handle_at(obj, vertex):
    """Number of the first handle that is turned on and has the vertex, or one that is merged with it; None if none
    has."""
    found = (_handle_of(obj, each) for each in region.copies_of(obj, vertex))
    return next((index for index in found if index is not None), None)


def near_vertices(obj, vertex, distance):
    """Indices, int32: `vertex` and those within `distance` of it along edges that no other handle has."""
    distances = region.Surface(obj, np.array([vertex])).distances(distance)
    near = np.flatnonzero(distances <= distance).astype(np.int32)
    is_free = [each == vertex or _handle_of(obj, int(each)) is None for each in near]
    return near[np.array(is_free)]


def _handle_of(obj, vertex):
    names = {obj.vertex_groups[each.group].name for each in obj.data.vertices[vertex].groups if each.weight > 0.0}
    for number, handle in enumerate(obj.meanvalue.handles):
        if handle.is_enabled and handle.name in names and not controls.is_deleted(handle):
            return number
    return None


def toggle_pin(obj, vertex, size, name=""):
    """Lets go of the pin `name`, or of the one that has the vertex, or pins the mesh there: Grab with Shift.

    The pin holds as much as a new handle of that size. Returns a message. @throws SceneError.
    """
    index = obj.meanvalue.handles.find(name)
    index = handle_at(obj, vertex) if index < 0 else index
    if index is not None:
        return _let_go(obj, index)
    members = near_vertices(obj, vertex, region.HANDLE_SHARE * region.radius(obj, size))
    rest, posed = positions(obj, members)
    is_posed = np.abs(posed - rest).max(initial=0.0) > 1e-5 * region.shown_size(obj)
    if is_posed:
        rig_space.measure(obj)  # throws before anything is changed
    handle = add_handle(obj, members, new_name=ids.PIN_GROUP)
    if is_posed:
        make_handle(obj, handle, members, PIN_COLOR)
        handle.is_pin = True
    else:
        make_pin(handle)
    obj.update_tag()
    return f"Pin '{handle.name}' holds {wording.vertices(len(members))}; Shift-click it again to let go"


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
