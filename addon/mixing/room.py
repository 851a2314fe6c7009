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


class MEANVALUE_MT_mix(bpy.types.Menu):
    """Mix shape keys so that parts turn"""

    bl_idname = "MEANVALUE_MT_mix"
    bl_label = "Shape Mix"

    def draw(self, context):
        morph.draw_buttons(self.layout, context)
        menus.draw_operators(self.layout, (None, *OPERATORS[1:]))


OPERATORS = (
    morph.MEANVALUE_OT_morph,
    bake_mix.MEANVALUE_OT_bake_mix,
)
CLASSES = (*OPERATORS, MEANVALUE_MT_mix, *panel.CLASSES)
HOOKS = (
    (menus.of_rooms, MEANVALUE_MT_mix.bl_idname),
    (roll.kinds, MixFollower),
    (bakeable.kinds, baked_mixes),
    (new_rest.made_of_rest, mixed_keys.made_of_rest),
)


def another_file():
    for obj in bpy.data.objects:
        mixed_keys.carry_over(obj)


objects_changed = another_file  # they may come from an older file
