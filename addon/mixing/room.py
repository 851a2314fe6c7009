# SPDX-License-Identifier: GPL-3.0-or-later
"""What mixing adds to Blender, for registration.py."""

import bpy

from ..live import roll
from ..scene import bakeable, new_rest
from ..widgets import menus
from . import panel
from .bridge import baked_mixes, mixed_keys
from .bridge.mix_follower import MixFollower
from .operators import bake_mix, morph
from .properties import PROPERTY_GROUPS, SETTINGS  # noqa: F401

#: Of the guide, see addon/manual.py.
PAGE = "shape_keys"

OPERATORS = (
    morph.MEANVALUE_OT_morph,
    bake_mix.MEANVALUE_OT_bake_mix,
)
MENU = menus.of_room("MEANVALUE_MT_mix", "Shape Mix", "Mix shape keys so that parts turn", OPERATORS)
CLASSES = (*OPERATORS, MENU, *panel.CLASSES)
HOOKS = (
    (menus.of_rooms, MENU.bl_idname),
    (roll.kinds, MixFollower),
    (bakeable.kinds, baked_mixes),
    (new_rest.made_of_rest, mixed_keys.made_of_rest),
)


def another_file():
    for obj in bpy.data.objects:
        mixed_keys.carry_over(obj)


objects_changed = another_file  # they may come from an older file
