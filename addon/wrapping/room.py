# SPDX-License-Identifier: GPL-3.0-or-later
"""What wrapping adds to Blender, for registration.py."""

import bpy

from ..widgets import menus, overlay
from . import panel
from .bridge import wrap_lines
from .operators import pick_wrap_pairs, wrap
from .properties import PROPERTY_GROUPS, SETTINGS  # noqa: F401

#: Of the guide, see addon/manual.py.
PAGE = "shape_keys"


class MEANVALUE_MT_wrap(menus.OperatorMenu, bpy.types.Menu):
    """Take the shape of a mesh that has other faces"""

    bl_idname = "MEANVALUE_MT_wrap"
    bl_label = "Wrap"
    operators = (
        pick_wrap_pairs.MEANVALUE_OT_pick_wrap_pairs,
        wrap.MEANVALUE_OT_wrap,
    )


CLASSES = (
    *MEANVALUE_MT_wrap.operators,
    MEANVALUE_MT_wrap,
    *panel.CLASSES,
)
HOOKS = (
    (menus.of_rooms, MEANVALUE_MT_wrap.bl_idname),
    (overlay.painters, wrap_lines.paint),
)
