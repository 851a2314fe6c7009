# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake has made of an object: `object.meanvalue.baked`. All rooms leave alone what a bake plays."""

import functools
import json

import bpy
from bpy.props import BoolProperty, PointerProperty, StringProperty

from ..rooms import ALL

#: What a bake may play from.
TO_CACHE, TO_KEYS, TO_BONES = 'POINT_CACHE', 'SHAPE_KEYS', 'ARMATURE'


class MEANVALUE_PG_baked(bpy.types.PropertyGroup):
    """What a bake has made of the object, so that it can be taken back. Lists are JSON"""

    target: StringProperty()  # "" for none
    modifier: StringProperty()
    keys: StringProperty()
    muted: StringProperty()
    hidden: StringProperty()  # modifiers that bones stand for, and whether viewport and renders had them
    rig: PointerProperty(type=bpy.types.Object)
    parent: PointerProperty(type=bpy.types.Object)  # armature that held it: glTF takes that for what deforms
    parent_inverse: StringProperty()  # of that, rows of a matrix
    was_live: BoolProperty()
    was_mixed: BoolProperty()
    note: StringProperty()  # what it is, for the panel


@functools.lru_cache(maxsize=16)
def names_in(text):
    """Names of a list in MEANVALUE_PG_baked. Remembered, since all that is drawn asks."""
    return tuple(json.loads(text or "[]"))


def source(obj):
    """The rooms.Bakeable that shapes an object, or None: then it is the handles."""
    return next((each for each in ALL.bakeables if each.is_meant(obj)), None)
