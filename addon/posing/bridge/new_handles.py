# SPDX-License-Identifier: GPL-3.0-or-later
"""New handles with a control, and new pins."""

import numpy as np

from ...scene import shape_keys, vertex_groups
from . import controls

#: Told apart in the overlay without looking alike to most eyes (Okabe and Ito 2008).
COLORS = (
    (0.90, 0.62, 0.00),
    (0.34, 0.71, 0.91),
    (0.00, 0.62, 0.45),
    (0.94, 0.89, 0.26),
    (0.84, 0.37, 0.00),
    (0.80, 0.47, 0.65),
)
PIN_COLOR = (0.0, 0.45, 0.70)


def add_handle(obj, members, *, group="", new_name=""):
    """A new handle, the active one: of the vertex group `group`, or of a new one with the vertices `members`."""
    settings = obj.meanvalue
    made_group = not group
    if made_group:
        controls.remove_deleted(obj)
        made = vertex_groups.make(obj, new_name)
        made.add(members.tolist(), 1.0, 'REPLACE')
        group = made.name
    handle = settings.handles.add()
    controls.name_group(handle, group, made_group)
    settings.active_handle = len(settings.handles) - 1
    return handle


def make_handle(obj, handle, members, color=None):
    """Gives a handle its control, at its vertices as they are shown. Returns the control."""
    carried = sum(other.follows == 'CONTROL' for other in obj.meanvalue.handles)
    handle.color = color or COLORS[carried % len(COLORS)]
    rest, shown = positions(obj, members)
    return controls.add_control(obj, handle, rest, shown)


def make_pin(handle):
    handle.follows = 'REST'
    handle.color = PIN_COLOR


def positions(obj, members):
    """(m x 3 in the rest shape, m x 3 as posed), float32."""
    rest = shape_keys.rest_positions(obj.data)[members]
    posed = shape_keys.result_positions(obj)
    return rest, rest if posed is None else posed[members]


def handle_at(obj, vertex):
    """Number of the first handle that is turned on and has the vertex; None if none has."""
    names = {obj.vertex_groups[each.group].name for each in obj.data.vertices[vertex].groups if each.weight > 0.0}
    for number, handle in enumerate(obj.meanvalue.handles):
        if handle.is_enabled and handle.name in names and not controls.is_deleted(handle):
            return number
    return None


def is_posed(obj, members):
    """Whether the vertices are shown elsewhere than in the rest shape."""
    rest, posed = positions(obj, members)
    size = np.linalg.norm(np.ptp(np.array(obj.bound_box), axis=0))
    return bool(np.abs(posed - rest).max(initial=0.0) > 1e-5 * size)
