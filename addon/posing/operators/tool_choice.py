# SPDX-License-Identifier: GPL-3.0-or-later
"""The Grab tool among Blender's tools: whether it is chosen, choosing it, and its settings."""

import bpy

from ...widgets import under_mouse
from ..bridge import region
from . import drag_circle

TOOL = "meanvalue.grab"

#: Of Size, a share of the mesh's size, where the shape suggests nothing and the artist has not changed it.
FIRST_SIZE = 0.2

#: A limb that is shorter on the screen, at interface scale 1, is not suggested, but the one that it is on.
LEAST_PIXELS = 40.0


def _tool(context):
    return context.workspace.tools.from_space_view3d_mode('OBJECT', create=False) if context.workspace else None


def is_active(context):
    tool = _tool(context)
    return context.mode == 'OBJECT' and tool is not None and tool.idname == TOOL


def settings(context):
    """Properties of the tool's operator, or None where no 3D View was shown yet."""
    tool = _tool(context)
    return None if tool is None else tool.operator_properties(TOOL)


def fits(context):
    """Whether a press begins with the Size that the shape suggests: as long as the artist leaves the tool's alone."""
    return is_active(context) and abs(settings(context).size - FIRST_SIZE) < 1e-6


def size_at(context, obj, pressed):
    """The Size that a press begins with. From afar fingers are too small to be meant."""
    if not fits(context):
        return settings(context).size
    shown = drag_circle.pixels(*under_mouse.view_of(context), pressed.place, 1.0)
    scale = shown * max(map(abs, obj.matrix_world.to_scale())) / context.preferences.system.ui_scale
    return region.suggested_size(obj, pressed.vertex, LEAST_PIXELS / max(scale, 1e-9)) or FIRST_SIZE


def choose(context):
    """Goes to Object Mode, where the tool is, as Blender's own step of undo."""
    if context.mode != 'OBJECT':
        bpy.ops.object.mode_set('EXEC_DEFAULT', True, mode='OBJECT')
    bpy.ops.wm.tool_set_by_id(name=TOOL, space_type='VIEW_3D')
    context.workspace.status_text_set(None)  # has the status bar drawn, which tells what the tool does
