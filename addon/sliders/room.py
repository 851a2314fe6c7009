# SPDX-License-Identifier: GPL-3.0-or-later
"""What values of shape keys add to Blender, for registration.py."""

import bpy

from ..live import roll
from ..posing.live import follower
from ..posing.operators import handles
from ..scene import shape_keys
from ..widgets import menus
from . import panel
from .bridge import driven_keys
from .bridge.key_follower import KeyFollower
from .operators import add_corrective, bake_values, import_values
from .properties import PROPERTY_GROUPS, SETTINGS  # noqa: F401

#: Of the guide, see addon/manual.py.
PAGE = "shape_key_values"

OPERATORS = (
    add_corrective.MEANVALUE_OT_add_corrective,
    import_values.MEANVALUE_OT_import_values,
    bake_values.MEANVALUE_OT_bake_values,
)
ABOUT = "Values of the shape keys that the mesh has"
MENU = menus.of_room("MEANVALUE_MT_sliders", "Shape Key Values", ABOUT, OPERATORS)
CLASSES = (*OPERATORS, MENU, *panel.CLASSES)


def meanvalue_draw_import_menu(self, _context):
    self.layout.operator(import_values.MEANVALUE_OT_import_values.bl_idname, text="Shape Key Values (.csv/.json)")


HOOKS = (
    (roll.kinds, KeyFollower),
    (follower.stand_ins, KeyFollower),
    (shape_keys.stand_ins, driven_keys),
    (handles.keyframers, driven_keys.keyframe),
    (menus.of_rooms, MENU.bl_idname),
    (bpy.types.TOPBAR_MT_file_import, meanvalue_draw_import_menu),
)
