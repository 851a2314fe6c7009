# SPDX-License-Identifier: GPL-3.0-or-later
"""What wrapping adds to Blender, for registration.py."""

from ..rooms import Room
from ..widgets import menus
from . import panel, properties
from .bridge import wrap_lines
from .operators import pick_wrap_pairs, wrap

ABOUT = "Take the shape of a mesh that has other faces"
ROOM = Room(
    page="shape_keys",
    modules=(properties, pick_wrap_pairs, wrap, panel),
    settings=properties.SETTINGS,
    menus=[menus.of_room("MEANVALUE_MT_wrap", "Wrap", ABOUT, pick_wrap_pairs, wrap)],
    painters=[wrap_lines.paint],
)
