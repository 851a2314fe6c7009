# SPDX-License-Identifier: GPL-3.0-or-later
"""How the shape keys of an object are mixed: `object.meanvalue.mix`. The sliders are those of the keys."""

import bpy
from bpy.props import BoolProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from ..live import engine
from ..scene import subject
from ..scene.declarations import aside
from .bridge import mix_layers
from .mix_follower import MixFollower


def _switch(settings, _context):
    """One of both shapes the mesh: a pose by handles, or the mix. Without the mix, keys add in straight lines."""
    obj = settings.id_data
    if settings.is_on:
        engine.turn_others_off(obj, MixFollower)
        if _can_begin(obj):
            mix_layers.ensure_key(obj)  # here, where the artist can undo it, and not while a slider is dragged
    elif subject.object_problem(obj) is None and not mix_layers.is_mixed_by_another(obj):
        mix_layers.remove(obj)
    obj.update_tag()


def _can_begin(obj):
    if subject.object_problem(obj) is not None or obj.mode != 'OBJECT' or obj.meanvalue.baked.target:
        return False
    return mix_layers.problem(obj) is None and not mix_layers.made_names(obj)


class MEANVALUE_PG_mix(bpy.types.PropertyGroup):
    """How shape keys are mixed, and what stands for the mix"""

    is_on: BoolProperty(
        name="Rotation-Aware Keys",
        description="Mix the shape keys so that parts turn, as limbs do, instead of shrinking along straight lines. "
        "The sliders stay those of the shape keys",
        update=_switch,
    )
    tolerance_share: FloatProperty(
        name="Tolerance",
        description="No vertex may be farther than this part of the mesh's size from where it belongs",
        default=0.2,
        min=0.001,
        soft_max=5.0,
        max=100.0,
        precision=3,
        subtype='PERCENTAGE',
    )
    most_keys: IntProperty(
        name="At Most", description="In-between keys that may be made", default=60, min=1, soft_max=200, max=2000
    )
    note: StringProperty(options={'HIDDEN'})  # what the in-between keys are, for the panel


PROPERTY_GROUPS = (MEANVALUE_PG_mix,)
SETTINGS = {"mix": aside(PointerProperty)(type=MEANVALUE_PG_mix)}
