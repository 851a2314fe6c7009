# SPDX-License-Identifier: GPL-3.0-or-later
"""What baking adds to Blender, for registration.py."""

from ..widgets import menus, panels
from . import panel
from .operators import bake, unbake
from .properties import PROPERTY_GROUPS, SETTINGS  # noqa: F401

#: Of the guide, see addon/manual.py.
PAGE = "baking"

OPERATORS = (
    bake.MEANVALUE_OT_bake,
    unbake.MEANVALUE_OT_unbake,
)
MENU = menus.of_room("MEANVALUE_MT_bake", "Bake", "Keep the animation of handles or sliders", OPERATORS)
CLASSES = (*OPERATORS, MENU, *panel.CLASSES)
HOOKS = (
    (menus.of_rooms, MENU.bl_idname),
    (panels.tops, panel.draw_top),
)
