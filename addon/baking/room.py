# SPDX-License-Identifier: GPL-3.0-or-later
"""What baking adds to Blender, for registration.py."""

import bpy

from ..widgets import menus, panels
from . import panel
from .operators import bake, unbake
from .properties import PROPERTY_GROUPS, SETTINGS  # noqa: F401

#: Of the guide, see addon/manual.py.
PAGE = "baking"


class MEANVALUE_MT_bake(menus.OperatorMenu, bpy.types.Menu):
    """Keep the animation of handles or sliders"""

    bl_idname = "MEANVALUE_MT_bake"
    bl_label = "Bake"
    operators = (
        bake.MEANVALUE_OT_bake,
        unbake.MEANVALUE_OT_unbake,
    )


CLASSES = (
    *MEANVALUE_MT_bake.operators,
    MEANVALUE_MT_bake,
    *panel.CLASSES,
)
HOOKS = (
    (menus.of_rooms, MEANVALUE_MT_bake.bl_idname),
    (panels.tops, panel.draw_top),
)
