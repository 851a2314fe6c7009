# SPDX-License-Identifier: GPL-3.0-or-later
"""What wrapping adds to Blender, for registration.py."""

from ..widgets import menus, overlay
from . import panel
from .bridge import wrap_lines
from .operators import pick_wrap_pairs, wrap
from .properties import PROPERTY_GROUPS, SETTINGS  # noqa: F401

#: Of the guide, see addon/manual.py.
PAGE = "shape_keys"

OPERATORS = (
    pick_wrap_pairs.MEANVALUE_OT_pick_wrap_pairs,
    wrap.MEANVALUE_OT_wrap,
)
MENU = menus.of_room("MEANVALUE_MT_wrap", "Wrap", "Take the shape of a mesh that has other faces", OPERATORS)
CLASSES = (*OPERATORS, MENU, *panel.CLASSES)
HOOKS = (
    (menus.of_rooms, MENU.bl_idname),
    (overlay.painters, wrap_lines.paint),
)
