# SPDX-License-Identifier: GPL-3.0-or-later
"""The lines of Blender's Info editor. Python has no access to them but by copying what is selected there."""

import bpy

from . import view


def reports():
    """All lines, oldest first. An area is an Info editor for a moment; nothing is drawn meanwhile."""
    window = view.window()
    area = next(area for area in window.screen.areas if area.type != 'VIEW_3D')
    former = area.ui_type
    clipboard = bpy.context.window_manager.clipboard
    area.type = 'INFO'
    try:
        space = area.spaces.active
        for kind in ("debug", "info", "operator", "warning", "error"):
            setattr(space, f"show_report_{kind}", True)
        region = next(region for region in area.regions if region.type == 'WINDOW')
        with bpy.context.temp_override(window=window, screen=window.screen, area=area, region=region):
            bpy.ops.info.select_all(action='SELECT')
            bpy.context.window_manager.clipboard = ""
            bpy.ops.info.report_copy()
            bpy.ops.info.select_all(action='DESELECT')
        return bpy.context.window_manager.clipboard.splitlines()
    finally:
        area.ui_type = former
        bpy.context.window_manager.clipboard = clipboard
