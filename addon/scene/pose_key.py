# SPDX-License-Identifier: GPL-3.0-or-later
"""Which shape key holds the pose: the result that Solve and Live write, `result_key` of an object's settings."""

from .. import compat
from . import key_marks
from .key_marks import Role


def result(obj):
    """The result key, or None if there is none. Cheap enough for drawing."""
    settings, keys = obj.meanvalue, getattr(obj.data, "shape_keys", None)
    return key_marks.find(keys, Role.POSE, settings.result_mark, settings.result_name) if settings.result_mark else None


def get_name(settings):
    """What `result_key` says: the name that the result has now; where there is none yet, the one that it will get."""
    key = result(settings.id_data)
    if key is not None:
        return key.name
    former = None if settings.is_property_set("result_name") else compat.stored(settings, "result_key")
    return former or settings.result_name


def choose(settings, name):
    """`result_key` was set: the key of that name is the result from here on, whoever made it."""
    obj, key = settings.id_data, result(settings.id_data)
    keys = getattr(obj.data, "shape_keys", None)
    chosen = keys.key_blocks.get(name) if keys is not None else None
    settings.result_name = name
    if key is not None and key == chosen:
        return
    settings.former_mark, settings.result_mark = settings.result_mark or settings.former_mark, 0
    if chosen is not None and chosen != keys.reference_key:
        adopt(settings, chosen)


def adopt(settings, key):
    """Has `key` be the result; another object with the mesh may have it already."""
    is_one = key_marks.role(key) == Role.POSE
    shared = key_marks.number(key) if is_one else 0
    if not is_one or key_marks.find(key.id_data, Role.POSE, shared) != key:  # a duplicate is another one
        shared = key_marks.put(key, Role.POSE, key_marks.new_number())
    settings.result_mark = shared


def pose_names(obj):
    """Names of the key that has the pose, and of the one that had it as long as that is shown."""
    settings = obj.meanvalue
    former = key_marks.find(obj.data.shape_keys, Role.POSE, settings.former_mark) if settings.former_mark else None
    return {key.name for key in (result(obj), former) if key is not None}


def was_called(obj, name):
    """The shape key that was called `name` when the result was written last, or None."""
    if name == obj.meanvalue.result_name and result(obj) is not None:
        return result(obj)
    return obj.data.shape_keys.key_blocks.get(name) if obj.data.shape_keys is not None else None
