# SPDX-License-Identifier: GPL-3.0-or-later
"""What mixing adds to Blender, for registration.py."""

from ..rooms import Room
from ..widgets import panels
from . import operators, panel, properties
from .bridge import mix_follower, mixed_keys

ROOM = Room(
    page="shape_keys",
    modules=(properties, operators, panel),
    settings=properties.SETTINGS,
    menus=[panels.of_room("MEANVALUE_MT_mix", "Shape Mix", "Mix shape keys so that parts turn", operators)],
    followers=[mix_follower.MixFollower],
    bakeables=[mix_follower],
    another_file=[mixed_keys.carry_over],
    objects_changed=[mixed_keys.carry_over],
)
