# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape keys of the add-on are known by a mark, whatever they are called (docs/decisions/0037-marks-of-shape-keys.md).

A shape key has no room for anything of ours but its Range Min, where a number near -1e-30 is nothing to the eye. It
says a role, and a number that tells keys of one role apart. Blender copies it with a key that is duplicated or joined:
of several that have the same mark one is meant, and the others are the artist's. And which key holds the pose: the
result that Solve and Live write, `result_key` of an object's settings.
"""

import enum
import math
import secrets
import zlib

import bpy

from . import actions


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


def result(obj):
    """The result key, or None if there is none. Cheap enough for drawing."""
    settings = obj.meanvalue
    return find(getattr(obj.data, "shape_keys", None), settings.result_mark, settings.result_name)


def pose_names(obj):
    """Of the result key, in a list; empty if there is none."""
    key = result(obj)
    return [] if key is None else [key.name]


def get_name(settings):
    """What `result_key` says: the name that the result has now; where there is none yet, the one that it will get."""
    key = result(settings.id_data)
    return settings.result_name if key is None else key.name


def choose(settings, name):
    """`result_key` was set: the key of that name is the result from here on, whoever made it. The former one is off."""
    obj, former = settings.id_data, result(settings.id_data)
    keys = getattr(obj.data, "shape_keys", None)
    chosen = keys.key_blocks.get(name) if keys is not None else None
    settings.result_name = name
    if former is not None and former == chosen:
        return
    if former is not None and not any(other.meanvalue.result_mark == settings.result_mark for other in sharing(obj)):
        show(former, None)
        former.slider_min = 0.0
    settings.result_mark = 0.0
    if chosen is not None and chosen != keys.reference_key:
        adopt(settings, chosen)


def adopt(settings, key):
    """Has `key` be the result; another object with the mesh may have it already."""
    is_duplicate = find(key.id_data, key.slider_min) != key
    if is_duplicate or role(key) != Role.POSE:
        key.slider_min = mark(Role.POSE, secrets.token_hex())
    settings.result_mark, settings.result_name = key.slider_min, key.name


def sharing(obj):
    """The other objects with the same mesh."""
    if obj.data.users == 1:
        return []
    return [other for other in bpy.data.objects if other != obj and other.data == obj.data]


def show(key, value):
    """value: None so that nothing shows it, exporters that know nothing of muted keys either."""
    key.mute, key.value = value is None, value or 0.0
    if _fade(key):
        _fade(key).mute = key.mute


def give_way(obj, *kept):
    """Has the pose fade as kept poses come in: `kept`, and those of before. Where one of these was deleted, for which
    Blender lets the driver rest, the others go on. Returns whether it fades: not where the artist moves its value."""
    key, fade = result(obj), _fade(result(obj))
    if not kept and (not fade or fade.driver.is_valid):
        return bool(fade)
    if not fade and (actions.driver_of(key) or len(actions.read_keys(key.id_data, key.path_from_id("value"))[0])):
        return False
    comers = [*replacing(obj), *kept][-60:]  # of more Blender would cut the expression
    key.driver_remove("value")
    others = {f"k{number}": each for number, each in enumerate(comers)}
    if others:
        actions.drive(key, others, "-".join(["1", *others]))
    return True


def _fade(key):
    """The driver of give_way(), or None; one that says something else is the artist's."""
    curve = key and actions.driver_of(key)
    names = curve.driver.variables.keys() if curve else []
    return curve if "k0" in names and curve.driver.expression == "-".join(["1", *names]) else None


def replacing(obj):
    """The kept poses that the pose fades for."""
    fade = _fade(result(obj))
    paths = [each.targets[0].data_path for each in fade.driver.variables] if fade else []
    return [key for key in obj.data.shape_keys.key_blocks if key.path_from_id("value") in paths] if paths else []
