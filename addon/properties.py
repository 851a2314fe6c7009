# SPDX-License-Identifier: GPL-3.0-or-later
"""What is kept on an object and on a collection: `object.meanvalue` and `collection.meanvalue`. Each room says what
there is of its own."""

import bpy
from bpy.props import PointerProperty

from . import ids
from .scene.baked import MEANVALUE_PG_baked
from .scene.declarations import aside


class MEANVALUE_PG_settings(bpy.types.PropertyGroup):  # noqa: N801  Blender's way
    """Settings of Mean-Value Deform for one object"""

    __annotations__ = {"baked": aside(PointerProperty)(type=MEANVALUE_PG_baked)}


def _groups(rooms):
    """In the order in which they need each other, and what each of the kinds of datablocks has of them."""
    own = [each for room in rooms for each in room.classes if issubclass(each, bpy.types.PropertyGroup)]
    of_collections = next((room.of_collections for room in rooms if room.of_collections), None)
    owners = {bpy.types.Object: MEANVALUE_PG_settings, bpy.types.Collection: of_collections}
    return [MEANVALUE_PG_baked, *own, MEANVALUE_PG_settings], {owner: kind for owner, kind in owners.items() if kind}


def register(rooms):
    groups, owners = _groups(rooms)
    for room in rooms:
        MEANVALUE_PG_settings.__annotations__.update(room.settings)
    for cls in groups:
        bpy.utils.register_class(cls)
    for owner, kind in owners.items():
        setattr(owner, ids.OBJECT_PROPERTY, PointerProperty(type=kind))


def unregister(rooms):
    groups, owners = _groups(rooms)
    for owner in owners:
        delattr(owner, ids.OBJECT_PROPERTY)
    for cls in reversed(groups):
        bpy.utils.unregister_class(cls)
