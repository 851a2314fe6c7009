# SPDX-License-Identifier: GPL-3.0-or-later
"""Which shape key holds the pose: the result that Solve and Live write, `result_key` of an object's settings."""

import secrets

import bpy

from . import actions, key_marks
from .key_marks import Role


def result(obj):
    """The result key, or None if there is none. Cheap enough for drawing."""
    settings = obj.meanvalue
    return key_marks.find(getattr(obj.data, "shape_keys", None), settings.result_mark, settings.result_name)


def names(obj):
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
    is_duplicate = key_marks.find(key.id_data, key.slider_min) != key
    if is_duplicate or key_marks.role(key) != Role.POSE:
        key.slider_min = key_marks.mark(Role.POSE, secrets.token_hex())
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
