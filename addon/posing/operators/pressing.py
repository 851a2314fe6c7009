# SPDX-License-Identifier: GPL-3.0-or-later
"""What the operators of the Grab tool share: what is pressed on, and Size."""

import bpy
from bpy_extras import view3d_utils
from mathutils import Vector

from ... import wording
from ...errors import SceneError
from ...scene import selection, subject, views
from ...widgets import under_mouse
from ...widgets.base import Reporting
from ..bridge import control_places, controls

#: Of Size, a share of the mesh's size: how far the surroundings follow at first, and its limits.
FIRST_SIZE = 0.2
LEAST_SIZE = 0.005
MOST_SIZE = 3.0

#: A press so near to a control, in pixels at interface scale 1, is meant for it, wherever the surface is.
CONTROL_PIXELS = 12.0


def size_property(description):
    return bpy.props.FloatProperty(
        name="Size",
        description=description,
        default=FIRST_SIZE,
        min=LEAST_SIZE,
        soft_max=1.0,
        max=MOST_SIZE,
        subtype='FACTOR',
    )


class ToolOperator(Reporting):
    """Mix-in: what is pressed on, for operators of the tool."""

    @classmethod
    def poll(cls, context):
        problem = None
        if context.mode != 'OBJECT':
            problem = "Grab works in Object Mode. Go back to Object Mode"
        if problem:
            cls.poll_message_set(wording.sentence(problem))
        return problem is None

    def warn(self, error):
        """As refuse(), without Blender's popup under the mouse, which takes the next click."""
        self.say('WARNING', wording.sentence(str(error)))
        return {'CANCELLED'}

    def find_pressed(self, context, event):
        """(mesh object, Pressed). @throws SceneError where there is nothing to take hold of.

        The active mesh counts, and its controls first. What is in front of it, or beside it, becomes the active one
        instead.
        """
        found = under_mouse.view_pressed(context, event)
        if found is None:
            raise SceneError("Press in a single 3D View: Grab does not work in Quad View, and not beside it")
        region, view, mouse = found
        obj = subject.of(context)
        at_control = _control_under(context, obj, region, view, mouse)
        if at_control is not None:
            return obj, at_control
        first = under_mouse.first_object(context, region, view, mouse)
        if first is None:
            raise SceneError("There is no surface under the mouse. Press on the mesh, or on the control of a handle")
        if first != obj:
            problem = subject.object_problem(first)
            if problem:
                raise SceneError(f"'{first.name}' is under the mouse. {problem}, or hide it to reach what is behind it")
            is_usable = obj is not None and subject.object_problem(obj) is None
            selection.choose(first)
            if is_usable and _has_handles(obj):
                raise SceneError(
                    f"'{first.name}' is in front here and is the active object now: press again to grab it. To reach "
                    f"what is behind it, hide it, or look at '{obj.name}' alone (Local View)"
                )
            obj = first
        pressed = under_mouse.press(obj, region, view, mouse)
        if pressed is None:
            raise SceneError(f"'{obj.name}' has no surface of its own under the mouse. Press on its faces")
        return obj, pressed


def require_vertex(obj, vertex):
    if not 0 <= vertex < len(obj.data.vertices):
        raise SceneError(
            f"'{obj.name}' has no vertex {vertex}: it has {wording.vertices(len(obj.data.vertices))}, counted from 0. "
            "Give one of them as 'vertex'"
        )


def _control_under(context, obj, region, view, mouse):
    """The Pressed of a control of `obj` that is to be seen under the mouse, the nearest to it; or None."""
    if subject.object_problem(obj) is not None:
        return None
    found, least = None, CONTROL_PIXELS * context.preferences.system.ui_scale
    for handle in obj.meanvalue.handles:
        if not handle.is_enabled or handle.follows != 'CONTROL' or controls.problem(obj, handle) is not None:
            continue
        place = Vector(control_places.world_of(handle)[:3, 3])
        seen = view3d_utils.location_3d_to_region_2d(region, view, place)
        is_hidden = not views.is_visible(handle.control, context.space_data)
        if seen is None or is_hidden or (seen - Vector(mouse)).length > least:
            continue
        least = (seen - Vector(mouse)).length
        found = under_mouse.Pressed(-1, place, region, view, handle.name)
    return found


def _has_handles(obj):
    return len(obj.meanvalue.handles) > 0
