# SPDX-License-Identifier: GPL-3.0-or-later
"""What baking adds to Blender, for registration.py."""

from ..rooms import Room
from ..widgets import panels
from . import operators, panel, properties

ROOM = Room(
    page="baking",
    modules=(properties, operators, panel),
    settings=properties.SETTINGS,
    menus=[panels.of_room("MEANVALUE_MT_bake", "Bake", "Keep the animation of handles or sliders", operators)],
    tops=[panel.draw_top],
)
