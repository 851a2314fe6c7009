# SPDX-License-Identifier: GPL-3.0-or-later
"""Which settings a binding depends on is said where they are declared, and nowhere else: every property of a group
counts, unless it is declared by `aside(...)`. Whoever remembers anything of an object compares values()."""

import functools

import bpy

from .. import compat

_aside = []  # what aside() declared; kept, since it is known by identity


def aside(declare):
    """`color: aside(FloatVectorProperty)(name=...)` declares a setting that no binding depends on: it changes nothing
    of the result, or is read anew for every solve, as controls are."""

    def declared(**keywords):
        setting = declare(**keywords)
        _aside.append(setting)
        return setting

    return declared


def tell(group, _context):
    """An `update` of a setting: has Blender report the object as updated, which panels and live posing listen for."""
    group.id_data.update_tag()


def values(group):
    """What a property group says that a binding depends on, as nested tuples of plain values, to be compared."""
    return tuple(_plain(getattr(group, name)) for name in _declared(type(group)))


def clear(group):
    """All settings of a property group have their defaults again."""
    for name in type(group).__annotations__:
        group.property_unset(name)


@functools.cache
def _declared(kind):
    """Names of what a binding depends on."""
    settings = kind.__annotations__.items()
    return tuple(name for name, setting in settings if not any(setting is each for each in _aside))


def _plain(value):
    if value is None or isinstance(value, (bool, float, int, str)):
        return value
    if isinstance(value, bpy.types.PropertyGroup):
        return values(value)
    if isinstance(value, bpy.types.ID):
        return compat.session_key(value)
    return tuple(values(item) if isinstance(item, bpy.types.PropertyGroup) else item for item in value)
