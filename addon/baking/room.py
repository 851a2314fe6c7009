# SPDX-License-Identifier: GPL-3.0-or-later
"""What baking adds to Blender, for registration.py."""

from ..rooms import Room
from ..widgets import menus
from . import panel, properties
from .operators import bake, unbake

ROOM = Room(
    page="baking",
    modules=(properties, bake, unbake, panel),
    settings=properties.SETTINGS,
    menus=[menus.of_room("MEANVALUE_MT_bake", "Bake", "Keep the animation of handles or sliders", bake, unbake)],
    tops=[panel.draw_top],
)
