# SPDX-License-Identifier: GPL-3.0-or-later
"""What mixing adds to Blender, for registration.py."""

import bpy

from .. import ids
from ..live import roll
from ..scene import bakeable, key_marks, new_rest
from ..scene.key_marks import Role
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
    """In files of before shape keys had marks the key of a mix has its name alone."""
    for obj in bpy.data.objects:
        if obj.meanvalue.mix.is_on and obj.type == 'MESH' and obj.data.library is None:
            key_marks.adopt(obj.data.shape_keys, Role.MIX, [ids.MIX_KEY])
