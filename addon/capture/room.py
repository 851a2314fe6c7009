# SPDX-License-Identifier: GPL-3.0-or-later
"""What motion capture adds to Blender, for registration.py."""

import bpy

from ..rooms import Room
from ..widgets import panels
from . import panel, properties
from .bridge import marker_pairs
from .operators import match_markers, take


def meanvalue_draw_import_menu(self, _context):
    operator = take.MEANVALUE_OT_import_motion.bl_idname
    self.layout.operator(operator, text="Motion Capture Markers (.c3d/.trc/.bvh/...)")


OPERATORS = take, match_markers
ROOM = Room(
    page="motion_capture",
    modules=(properties, *OPERATORS, panel),
    settings=properties.SETTINGS,
    of_collections=properties.MEANVALUE_PG_take,
    menus=[panels.of_room("MEANVALUE_MT_capture", "Motion Capture", "Move the mesh by recorded markers", *OPERATORS)],
    blender_menus=[(bpy.types.TOPBAR_MT_file_import, meanvalue_draw_import_menu)],
    finders=[marker_pairs.mesh_of_marker],
    painters=[marker_pairs.paint],
    chosen=[marker_pairs.note_active],
)
