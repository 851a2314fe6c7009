# SPDX-License-Identifier: GPL-3.0-or-later
"""What values of shape keys add to Blender, for registration.py."""

import bpy

from ..rooms import Room
from ..widgets import panels
from . import operators, panel, properties
from .bridge import driven_keys


def meanvalue_draw_import_menu(self, _context):
    self.layout.operator(operators.MEANVALUE_OT_import_values.bl_idname, text="Shape Key Values (.csv/.json)")


ABOUT = "Values of the shape keys that the mesh has"
ROOM = Room(
    page="shape_key_values",
    modules=(properties, operators, panel),
    settings=properties.SETTINGS,
    menus=[panels.of_room("MEANVALUE_MT_sliders", "Shape Key Values", ABOUT, operators)],
    blender_menus=[(bpy.types.TOPBAR_MT_file_import, meanvalue_draw_import_menu)],
    followers=[driven_keys.KeyFollower],
    shown_keys=[driven_keys],
)
