# SPDX-License-Identifier: GPL-3.0-or-later
"""How the shape keys of an object are mixed: `object.meanvalue.mix`. The sliders are those of the keys."""

import bpy
from bpy.props import BoolProperty, FloatProperty, PointerProperty

from ..scene.declarations import aside
from .bridge import mix_follower


class MEANVALUE_PG_mix(bpy.types.PropertyGroup):
    """How shape keys are mixed, and what stands for the mix"""

    is_on: BoolProperty(
        name="Rotation-Aware Keys",
        description="Mix the shape keys so that parts turn, as limbs do, instead of shrinking along straight lines",
        update=lambda settings, _context: mix_follower.turned(settings.id_data),
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


SETTINGS = {"mix": aside(PointerProperty)(type=MEANVALUE_PG_mix)}
