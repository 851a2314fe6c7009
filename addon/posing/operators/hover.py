# SPDX-License-Identifier: GPL-3.0-or-later
"""What would follow a press of the Grab tool, while the mouse rests over the active mesh."""

from types import SimpleNamespace

import bpy
import numpy as np

from ...errors import MeanValueError
from ...scene import mesh_arrays, shown_shape, subject, views
from ...widgets import under_mouse
from ..bridge import new_handles, region
from ..core.tinted_faces import tinted_faces
from . import drag_circle, tool_choice

#: How long the mouse has to rest.
REST_SECONDS = 0.1

#: Meshes of more vertices, with their modifiers, are not read before they are pressed.
MOST_VERTICES = 200_000

_found = None
_region = _mouse = None  # where the mouse was seen last: pointer of the region, (x, y) in the window


def of(context, obj):
    """What would follow in the region that is drawn, or None: name of the object, place of the press in the world,
    size; tint, freedom and corners as of an overlay_data.Look."""
    is_there = _found is not None and _found.name == obj.name and not drag_circle.is_shown
    is_there = is_there and _region == context.region.as_pointer() and tool_choice.is_active(context)
    return _found if is_there else None


def mouse_at(context, mouse):
    """The tool draws its cursor there. What is under the mouse is looked at once it rests: drawing must not."""
    global _region, _mouse
    if (_region, _mouse) != (context.region.as_pointer(), tuple(mouse)):
        _region, _mouse = context.region.as_pointer(), tuple(mouse)
        _stop()
        bpy.app.timers.register(_look, first_interval=REST_SECONDS)


def forget():
    global _found
    _found = None
    _stop()


def _stop():
    if bpy.app.timers.is_registered(_look):
        bpy.app.timers.unregister(_look)


def _look():
    """Timer, called once."""
    global _found
    before, _found = _found, None
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            for each in area.regions:
                if each.as_pointer() == _region:
                    with bpy.context.temp_override(window=window, area=area, region=each):
                        _found = _find(bpy.context, (_mouse[0] - each.x, _mouse[1] - each.y))
    if before is not _found:
        views.draw_again('WINDOW')


def is_small(context, obj):
    """Whether it may be read without a press."""
    evaluated = obj.evaluated_get(context.view_layer.depsgraph)
    return max(len(obj.data.vertices), len(evaluated.data.vertices)) <= MOST_VERTICES


def _find(context, mouse):
    obj, view = subject.of(context), under_mouse.view_of(context)
    is_asked = view is not None and tool_choice.is_active(context) and not drag_circle.is_shown
    if not is_asked or subject.object_problem(obj) is not None or not views.is_pressable(obj, context):
        return None
    try:
        pressed = under_mouse.press(obj, *view, mouse) if is_small(context, obj) else None
        if pressed is None or new_handles.handle_at(obj, pressed.vertex) is not None:
            return None
        size = tool_choice.size_at(context, obj, pressed)
        surface = region.Surface(obj, [pressed.vertex])
        freedom = surface.falloff(size * surface.diagonal, region.HANDLE_SHARE).astype(np.float32)
    except MeanValueError:
        return None  # a press says why
    tint, corners = tinted_faces(mesh_arrays.shown_triangles(obj.data), freedom > 0.0)
    tint, freedom = shown_shape.positions(obj)[tint], freedom[tint]
    return SimpleNamespace(name=obj.name, place=pressed.place, size=size, tint=tint, freedom=freedom, corners=corners)
