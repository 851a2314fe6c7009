# SPDX-License-Identifier: GPL-3.0-or-later
"""What wrapping adds to Blender, for registration.py."""

from ..rooms import Room
from ..widgets import panels
from . import operators, panel, properties
from .bridge import wrap_scene

ABOUT = "Take the shape of a mesh that has other faces"
ROOM = Room(
    page="shape_keys",
    modules=(properties, operators, panel),
    settings=properties.SETTINGS,
    menus=[panels.of_room("MEANVALUE_MT_wrap", "Wrap", ABOUT, operators)],
    painters=[wrap_scene.paint],
)
