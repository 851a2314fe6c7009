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
    hidden: StringProperty()  # types of the modifiers before bones, and where those they stand for were shown
    rig: PointerProperty(type=bpy.types.Object)
    former_groups: StringProperty()  # {bone: what the artist's group of that name is called meanwhile}
    worst: StringProperty()  # the frame where bones are off most, and the vertices
    parent: PointerProperty(type=bpy.types.Object)  # armature that held it: glTF takes that for what deforms
    parent_inverse: StringProperty()  # of that, rows of a matrix
    was_live: BoolProperty()
    was_mixed: BoolProperty()
    note: StringProperty()  # what it is, for the panel


@functools.lru_cache(maxsize=16)
def names_in(text):
    """Names of a list in MEANVALUE_PG_baked. Remembered, since all that is drawn asks."""
    return tuple(json.loads(text or "[]"))


def hidden(obj):
    """{name: (in the viewport, in renders)}, where they were shown, of the modifiers that a bake has turned off. They
    are told by their types in turn: names may be others by now."""
    left, found = [*names_in(obj.meanvalue.baked.hidden)], {}
    for each in obj.modifiers if left else ():
        if row := next((row for row in left if row[0] == each.type), None):
            left.remove(row)
            found[each.name] = row[1:]
    return {name: shown for name, shown in found.items() if shown}


def source(obj):
    """The rooms.Bakeable that shapes an object, or None: then it is the handles."""
    return next((each for each in ALL.bakeables if each.is_meant(obj)), None)
