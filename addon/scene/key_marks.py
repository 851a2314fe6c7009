# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape keys of the add-on are known by a mark, whatever they are called (docs/decisions/0037-marks-of-shape-keys.md).

A shape key has no room for anything of ours but its Range Min, where a number near -1e-30 is nothing to the eye. It
says a role, and a number that tells keys of one role apart. Blender copies it with a key that is duplicated or joined:
of several that have the same mark one is meant, and the others are the artist's.
"""

import enum
import math
import zlib


class Role(enum.IntEnum):
    POSE = 0
    MIX = 1
    RIG_POSE = 2
    CORRECTIVE = 3
    KEPT = 4  # the artist's, never written
    WRAP = 5


def mark(role, name=""):
    """As float32 has it exactly. name: keys of one role with other names have other marks."""
    return -math.ldexp(1.0 + (zlib.crc32(name.encode()) >> 9) / 2**23, -100 - role)


def role(key):
    """The Role of a shape key, or None."""
    low = key.slider_min
    return Role(-99 - math.frexp(low)[1]) if -(2.0**-99) < low <= -(2.0 ** -(99 + len(Role))) else None


def find(keys, mark, name=""):
    """The key of a mesh's shape keys, or None, that has the mark; of several the one that is called `name`, or else the
    first: Blender puts what it duplicates or joins behind. Cheap enough for drawing."""
    if keys is None or not mark:
        return None
    named = keys.key_blocks.get(name)
    is_named = named is not None and named.slider_min == mark
    return named if is_named else next((key for key in keys.key_blocks if key.slider_min == mark), None)


def of_role(keys, *roles):
    """Those that have one of the roles; of several with the same mark, which a new key of a former name has too, the
    first, but of kept ones all."""
    found = {}
    for key in keys.key_blocks if keys is not None else ():
        if role(key) in roles:
            found.setdefault(key.name if role(key) == Role.KEPT else key.slider_min, key)
    return list(found.values())


def only(keys, role):
    """The key of a role that a mesh has one of, or None."""
    return find(keys, mark(role))


def claim(key):
    """Others with the mark of this one are duplicates, and the artist's."""
    if role(key) is not None:
        for other in key.id_data.key_blocks:
            if other.slider_min == key.slider_min and other != key:
                other.slider_min = 0.0
