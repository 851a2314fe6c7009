# SPDX-License-Identifier: GPL-3.0-or-later
"""What mixing adds to Blender, for registration.py."""

from ..live import engine
from ..scene import bakeable
from . import mix_session, panel
from .bridge import baked_mixes
from .mix_follower import MixFollower
from .operators import bake_mix, morph, remove_in_betweens
from .properties import PROPERTY_GROUPS, SETTINGS  # noqa: F401

CLASSES = (
    morph.MEANVALUE_OT_morph,
    morph.MEANVALUE_OT_blend_part,
    bake_mix.MEANVALUE_OT_bake_mix,
    remove_in_betweens.MEANVALUE_OT_remove_in_betweens,
    *panel.CLASSES,
)


def register():
    engine.add_kind(MixFollower)
    bakeable.kinds.append(baked_mixes)


def unregister():
    bakeable.kinds.remove(baked_mixes)
    engine.remove_kind(MixFollower)
    mix_session.clear()


def another_file():
    mix_session.clear()
