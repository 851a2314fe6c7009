# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape keys of the add-on are known by a mark, whatever they are called (docs/decisions/0037-marks-of-shape-keys.md).

A shape key has no room for anything of ours but its Range Min, where a number near -1e-30 is nothing to the eye. It
says a role, and a number that tells keys of one role apart. Blender copies it with a key that is duplicated or joined:
of several that have the same mark one is meant, and the others are the artist's.
"""

import enum
import math
import secrets
import zlib

#: What a float32 holds exactly beside its exponent.
_BITS = 23


class Role(enum.IntEnum):
    POSE = 0
    MIX = 1
    RIG_POSE = 2
    CORRECTIVE = 3
    KEPT = 4  # the artist's, never written


def new_number():
    return secrets.randbits(_BITS - 1) + 1


def number_of(name):
    """By which a key is known to be called as when it was marked."""
    return zlib.crc32(name.encode()) >> (32 - _BITS)


def put(key, role, number=None):
    """Marks a shape key. Returns the number, that of its name if none is given."""
    number = number_of(key.name) if number is None else number
    key.slider_min = _mark(role, number)
    return number


def release(key):
    """From here on it is the artist's."""
    key.slider_min = 0.0


def role(key):
    """The Role of a shape key, or None."""
    if not -1e-29 < key.slider_min < 0.0:
        return None
    found = -99 - math.frexp(-key.slider_min)[1]
    return Role(found) if found in Role.__members__.values() else None


def number(key):
    """Of the mark of a shape key that has a role."""
    return int((2.0 * math.frexp(-key.slider_min)[0] - 1.0) * 2**_BITS)


def find(keys, role, number, name=""):
    """The key of a mesh's shape keys, or None, that has the mark; of several the one that is called `name`, or else the
    first: Blender puts what it duplicates or joins behind. Cheap enough for drawing."""
    if keys is None:
        return None
    mark, named = _mark(role, number), keys.key_blocks.get(name)
    if named is not None and named.slider_min == mark:
        return named
    return next((key for key in keys.key_blocks if key.slider_min == mark), None)


def of_role(keys, wanted):
    """Those that have the role, of several with the same mark the first."""
    found = {}
    for key in keys.key_blocks if keys is not None else ():
        if role(key) == wanted:
            found.setdefault(key.slider_min, key)
    return list(found.values())


def only(keys, role):
    """The key of a role that a mesh has one of, or None."""
    return next(iter(of_role(keys, role)), None)


def claim(key):
    """Others with the mark of this one are duplicates, and the artist's."""
    mark = key.slider_min
    if role(key) is not None:
        for other in key.id_data.key_blocks:
            if other.slider_min == mark and other != key:
                release(other)


def adopt(keys, role, names):
    """Marks those called so, of a file of before there were marks, where none has the role yet."""
    if keys is not None and not of_role(keys, role):
        for name in names:
            if name in keys.key_blocks:
                put(keys.key_blocks[name], role)


def _mark(role, number):
    return -math.ldexp(1.0 + number / 2**_BITS, -100 - role)
