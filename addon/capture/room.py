# SPDX-License-Identifier: GPL-3.0-or-later
"""What motion capture adds to Blender, for registration.py."""

import bpy
from bpy.props import PointerProperty

from .. import ids
from ..scene import subject
from ..widgets import menus, overlay
from . import panel
from .bridge import marker_pairs, pair_lines
from .operators import (
    import_motion,
    marker_problems,
    match_markers,
    pick_marker_point,
)
from .properties import PROPERTY_GROUPS, SETTINGS, MEANVALUE_PG_take  # noqa: F401

#: Of the guide, see addon/manual.py.
PAGE = "motion_capture"

OPERATORS = (
    import_motion.MEANVALUE_OT_import_motion,
    marker_problems.MEANVALUE_OT_find_marker_problems,
    marker_problems.MEANVALUE_OT_swap_markers,
    match_markers.MEANVALUE_OT_match_markers,
    pick_marker_point.MEANVALUE_OT_pick_marker_point,
)
MENU = menus.of_room("MEANVALUE_MT_capture", "Motion Capture", "Move the mesh by recorded markers", OPERATORS)
CLASSES = (*OPERATORS, MENU, *panel.CLASSES, *import_motion.FILE_HANDLERS)


def meanvalue_draw_import_menu(self, _context):
    self.layout.operator(
        import_motion.MEANVALUE_OT_import_motion.bl_idname, text="Motion Capture Markers (.c3d/.trc/.bvh)"
    )


HOOKS = (
    (menus.of_rooms, MENU.bl_idname),
    (subject.finders, marker_pairs.mesh_of_marker),
    (overlay.painters, pair_lines.paint),
    (bpy.types.TOPBAR_MT_file_import, meanvalue_draw_import_menu),
)


def register():
    setattr(bpy.types.Collection, ids.OBJECT_PROPERTY, PointerProperty(type=MEANVALUE_PG_take))


def unregister():
    delattr(bpy.types.Collection, ids.OBJECT_PROPERTY)


def chosen(active):
    """The artist made an object the active one, or took it to another mode."""
    marker_pairs.note_active(active)
