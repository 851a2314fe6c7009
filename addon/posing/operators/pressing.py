# SPDX-License-Identifier: GPL-3.0-or-later
"""What Grab is pressed on."""

import numpy as np
from bpy_extras import view3d_utils
from mathutils import Vector

from ...errors import SceneError
from ...scene import pose_objects, subject, views, worn
from ...widgets import picking
from ..bridge import control_places, targets

#: A press so near to a control, in pixels at interface scale 1, is meant for it, wherever the surface is.
CONTROL_PIXELS = 12.0


def find_view(context):
    """(region, view) as of picking.view_of(). @throws SceneError where there is none."""
    found = picking.view_of(context)
    if found is None:
        raise SceneError("Press in a single 3D View: Grab does not work in Quad View, and not beside it")
    return found


def find_pressed(context, mouse):
    """(mesh object, Pressed, name of the active mesh that it covers or "") at `mouse`, (2,) pixels in the region. The
    active mesh's controls come first. @throws SceneError where there is nothing to grab."""
    seen = *find_view(context), tuple(mouse)
    active = subject.of(context)
    is_usable = subject.object_problem(active) is None
    at_control = _control_under(context, active, *seen) if is_usable else None
    if at_control is not None:
        return active, at_control, ""
    obj, place = picking.first_object(context, *seen)
    if obj is None:
        raise SceneError("There is no surface under the mouse. Press on the mesh, or on the control of a handle")
    obj = pose_objects.of(obj) or obj
    below = worn.carrier(obj) or worn.body_of(obj, active)
    if below is not None and place is not None and views.is_pressable(below, context):
        place = below.matrix_world.inverted_safe() @ obj.matrix_world @ Vector(place)
        obj, place = below, np.array(place, np.float32)
    if problem := subject.problem_to_begin(obj) or subject.mode_problem(obj):
        raise SceneError(f"'{obj.name}' is under the mouse. {problem}, or hide it to reach what is behind it")
    pressed = picking.press(obj, *seen, place)
    if pressed is None:
        raise SceneError(f"'{obj.name}' has no surface of its own under the mouse. Press on its faces")
    is_apart = obj != active and is_usable and len(active.meanvalue.handles) > 0
    return obj, pressed, active.name if is_apart and picking.place_under(active, *seen) is not None else ""


def _control_under(context, obj, region, view, mouse):
    """The Pressed of a control of `obj` that is to be seen under the mouse, the nearest to it; or None."""
    found, least = None, CONTROL_PIXELS * context.preferences.system.ui_scale
    for handle in targets.followed_handles(obj):
        place = Vector(control_places.world_of(handle)[:3, 3])
        seen = view3d_utils.location_3d_to_region_2d(region, view, place)
        away = np.inf if seen is None else (seen - Vector(mouse)).length
        if away <= least and views.is_visible(handle.control, context.space_data):
            least, found = away, picking.Pressed(-1, place, handle.name)
    return found


def in_front(obj, covered):
    """A sentence on a press that may be meant for what is behind."""
    return f"'{obj.name}' is in front of '{covered}' here. Click it to make it the active object, or hide it"
