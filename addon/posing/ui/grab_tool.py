# SPDX-License-Identifier: GPL-3.0-or-later
"""The tool in the toolbar of Object Mode: press on the mesh and drag."""

import bpy

from ...scene import subject
from ..bridge import region
from ..operators import drag_circle, hover, tool_choice

#: Fainter than while something is dragged: how far the mesh is from the eye under the mouse is not known yet.
HOVER_COLOR = (1.0, 1.0, 1.0, 0.35)


class MeanValueGrabTool(bpy.types.WorkSpaceTool):
    bl_space_type = 'VIEW_3D'
    bl_context_mode = 'OBJECT'
    bl_idname = "meanvalue.grab"
    bl_label = "Mean-Value Grab"
    bl_description = "Press on a mesh and drag. The wheel says how much follows. Shift-click pins, a click selects"
    bl_icon = "brush.uv_sculpt.grab"  # of those that Blender has from 3.4 to 5.x
    bl_cursor = 'CROSSHAIR'
    bl_keymap = (
        ("meanvalue.grab", {"type": 'LEFTMOUSE', "value": 'PRESS'}, None),
        (
            "meanvalue.grab",
            {"type": 'LEFTMOUSE', "value": 'PRESS', "shift": True},
            {"properties": [("pin", True)]},
        ),
    )

    def draw_settings(context, layout, tool):  # noqa: N805  Blender calls it without an instance
        layout.prop(tool.operator_properties("meanvalue.grab"), "size")

    def draw_cursor(context, tool, mouse):  # noqa: N805
        obj = subject.of(context)
        view = context.region_data
        if drag_circle.is_shown or view is None or subject.object_problem(obj) is not None:
            return
        hover.mouse_at(context, mouse)
        found = hover.of(context, obj)
        size = tool.operator_properties("meanvalue.grab").size if found is None else found.size
        length = size * region.shown_size(obj) * max(map(abs, obj.matrix_world.to_scale()))
        place = obj.matrix_world.translation if found is None else found.place
        drag_circle.draw(mouse, HOVER_COLOR, drag_circle.pixels(context.region, view, place, length))


def meanvalue_draw_status(header, context):
    """What Blender's status bar, which knows one key a tool, leaves out."""
    if context.workspace is not None and tool_choice.is_active(context) and not drag_circle.is_shown:
        header.layout.label(text="Drag: Grab    Shift-Click: Pin    Click: Select    Wheel in the Drag: Size")


def register():
    """Not without a window: Blender has no keymap then when it turns on the add-ons of the preferences."""
    if not bpy.app.background:
        bpy.utils.register_tool(MeanValueGrabTool, after={"builtin.transform"}, separator=True)
        bpy.types.STATUSBAR_HT_header.prepend(meanvalue_draw_status)


def unregister():
    if not bpy.app.background:
        bpy.types.STATUSBAR_HT_header.remove(meanvalue_draw_status)
        bpy.utils.unregister_tool(MeanValueGrabTool)
