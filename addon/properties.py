# SPDX-License-Identifier: GPL-3.0-or-later
"""What is kept on an object: `object.meanvalue`. Each room says what there is of its own: PROPERTY_GROUPS, the classes,
and SETTINGS, {name in `object.meanvalue`: property}."""

import bpy
from bpy.props import PointerProperty

from . import ids
from .scene.baked import MEANVALUE_PG_baked
from .scene.declarations import aside


class MEANVALUE_PG_settings(bpy.types.PropertyGroup):  # noqa: N801  Blender's way
    """Settings of Mean-Value Deform for one object"""

    __annotations__ = {"baked": aside(PointerProperty)(type=MEANVALUE_PG_baked)}


def register(rooms):
    bpy.utils.register_class(MEANVALUE_PG_baked)
    for room in rooms:
        for cls in room.PROPERTY_GROUPS:
            bpy.utils.register_class(cls)
        MEANVALUE_PG_settings.__annotations__.update(room.SETTINGS)
    bpy.utils.register_class(MEANVALUE_PG_settings)
    setattr(bpy.types.Object, ids.OBJECT_PROPERTY, PointerProperty(type=MEANVALUE_PG_settings))


def unregister(rooms):
    delattr(bpy.types.Object, ids.OBJECT_PROPERTY)
    bpy.utils.unregister_class(MEANVALUE_PG_settings)
    for room in reversed(rooms):
        for cls in reversed(room.PROPERTY_GROUPS):
            bpy.utils.unregister_class(cls)
    bpy.utils.unregister_class(MEANVALUE_PG_baked)
