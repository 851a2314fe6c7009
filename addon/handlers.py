# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender tells us: that an object was edited, that undo or loading replaced everything.

The handlers only forget or mark; they never change the scene. A timer has the panel drawn again when an edited
object has been left alone for a moment, since Blender has no reason to draw then.
"""

import bpy
from bpy.app.handlers import persistent

from . import session
from .bridge import object_status


@persistent
def meanvalue_mark_edited(_scene, depsgraph):
    for update in depsgraph.updates:
        is_edited_object = update.is_updated_geometry and isinstance(update.id, bpy.types.Object)
        if is_edited_object and object_status.mark_edited(update.id.original):
            _draw_again_when_quiet()


@persistent
def meanvalue_forget_status(*_):
    object_status.clear()


@persistent
def meanvalue_forget_session(*_):
    object_status.clear()
    session.clear()


_HANDLERS = (
    ("depsgraph_update_post", meanvalue_mark_edited),
    ("undo_post", meanvalue_forget_status),
    ("redo_post", meanvalue_forget_status),
    ("load_post", meanvalue_forget_session),
)


def _draw_again_when_quiet():
    if _is_drawn() and not bpy.app.timers.is_registered(_draw_again):
        bpy.app.timers.register(_draw_again, first_interval=object_status.QUIET_SECONDS)


def _is_drawn():
    """Timers are never called in the background, and one left over keeps the bpy module of 4.5 from ending."""
    return not bpy.app.background


def _draw_again():
    """Timer: None ends it, a number calls it again after so many seconds."""
    remaining = object_status.quiet_in()
    if remaining > 0.0:
        return remaining
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == 'VIEW_3D':
                area.tag_redraw()
    return None


def register():
    unregister()
    for list_name, handler in _HANDLERS:
        getattr(bpy.app.handlers, list_name).append(handler)


def unregister():
    """By name: after reloading the add-on, handlers of the former one are other functions."""
    for list_name, handler in _HANDLERS:
        handlers = getattr(bpy.app.handlers, list_name)
        handlers[:] = [other for other in handlers if getattr(other, "__name__", "") != handler.__name__]
    if bpy.app.timers.is_registered(_draw_again):
        bpy.app.timers.unregister(_draw_again)
