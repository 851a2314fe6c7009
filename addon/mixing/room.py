# SPDX-License-Identifier: GPL-3.0-or-later
"""What mixing adds to Blender, for registration.py."""

import bpy

from ..rooms import Room
from ..widgets import panels
from . import operators, panel, properties
from .bridge import mix_follower, mixed_keys


def _carry_over():
    """Objects may come from an older file."""
    for obj in bpy.data.objects:
        mixed_keys.carry_over(obj)


ROOM = Room(
    page="shape_keys",
    modules=(properties, operators, panel),
    settings=properties.SETTINGS,
    menus=[panels.of_room("MEANVALUE_MT_mix", "Shape Mix", "Mix shape keys so that parts turn", operators)],
    followers=[mix_follower.MixFollower],
    bakeables=[mix_follower],
    made_of_rest=[mixed_keys.made_of_rest],
    another_file=[_carry_over],
    objects_changed=[_carry_over],
)
