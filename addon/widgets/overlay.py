# SPDX-License-Identifier: GPL-3.0-or-later
"""What is drawn over the mesh that the artist works on, in 3D Views. Rooms draw it."""

import traceback

import bpy

from ..rooms import ALL
from ..scene import subject, views

#: In modes that are not here, Blender has a mesh of its own.
MODES = {'OBJECT', 'WEIGHT_PAINT', 'VERTEX_PAINT', 'TEXTURE_PAINT'}

#: Why nothing is drawn any more until the add-on is enabled again, or "".
problem = ""

_handler = None


def subject_to_draw(context):
    """The object whose overlay is to be seen in the 3D View of `context`, or None."""
    space = context.space_data
    if not space.overlay.show_overlays:
        return None
    obj = subject.of(context)
    if subject.object_problem(obj) is not None or not obj.meanvalue.show_overlay or obj.mode not in MODES:
        return None
    return obj if views.is_visible(obj, space) else None


def draw():
    """Called by Blender at every redraw of every 3D View: after a mistake of ours it is not called for ever more."""
    global problem
    if problem:
        return
    try:
        obj = subject_to_draw(bpy.context)
        for paint in ALL.painters if obj is not None else ():
            paint(bpy.context, obj)
    except Exception as error:
        traceback.print_exc()
        problem = f"The overlay cannot be drawn: {error}. Please report this; the console has the details"


def register():
    global _handler, problem
    problem = ""
    if not bpy.app.background:
        _handler = bpy.types.SpaceView3D.draw_handler_add(draw, (), 'WINDOW', 'POST_VIEW')


def unregister():
    global _handler
    if _handler is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_handler, 'WINDOW')
    _handler = None
