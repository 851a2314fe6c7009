# SPDX-License-Identifier: GPL-3.0-or-later
"""Members of vertex groups, and shape keys with the groups that mask them. A member has a weight above zero."""

import array
import itertools

import numpy as np

from .. import ids
from ..errors import SceneError
from . import kept, shape_keys
from .core.key_shapes import KeyShapes, Slider
from .core.point_sets import require_finite

#: Weights that the add-on writes have this many steps, as many as Blender has colors for painted ones.
WEIGHT_STEPS = 255


def read(obj, names):
    """{name: (ascending vertex indices, int32, weights, float32)} of the groups that exist, of weights above 0.

    Blender has no bulk access to weights, so this is the slow part of reading a scene: 0.25 s for a million vertices,
    1 s where each is in four groups. All are read in one pass, and none that is known since the last edit.
    """
    known = _known(obj)
    indices = {group.name: group.index for group in obj.vertex_groups}
    there = {name: (name, indices[name]) for name in names if name in indices}
    unknown = [each for each in there.values() if each not in known]
    found = {index: (array.array("i"), array.array("f")) for _name, index in unknown}
    for number, vertex in enumerate(obj.data.vertices if found else ()):
        for element in vertex.groups:
            if element.group in found and element.weight > 0.0:
                numbers, weights = found[element.group]
                numbers.append(number)
                weights.append(element.weight)
    known.update({each: tuple(map(np.array, found[each[1]])) for each in unknown})
    return {name: known[each] for name, each in there.items()}


def _known(obj):
    """{(name, index) of a group: what read() gives} since the last edit."""
    return kept.of(obj.data, "groups", dict)


def members(obj, names):
    """{name: ascending vertex indices, int32} of the groups that exist."""
    return {name: numbers for name, (numbers, _weights) in read(obj, names).items()}


def weights(obj, names):
    """{name: n float64, 0 to 1} of the groups that exist."""
    found = read(obj, names)
    return {name: np.bincount(*found[name], len(obj.data.vertices)).astype(np.float64) for name in found}


def require(obj, name, role, remedy):
    """@throws SceneError if the object has no vertex group `name`."""
    if name not in obj.vertex_groups:
        raise SceneError(f"'{obj.name}' has no vertex group '{name}', which is {role}. {remedy}")


def active_name(obj):
    """Name of the active group; "" if there is none."""
    return obj.vertex_groups.active.name if obj.vertex_groups.active is not None else ""


def make_active(obj, name):
    """Makes the group `name` the active one, if it is there."""
    if name in obj.vertex_groups:
        obj.vertex_groups.active_index = obj.vertex_groups[name].index


def make(obj, name):
    """A new vertex group, called so, or numbered where that is taken or names a bone, whose skin it would be."""
    rigs = {modifier.object for modifier in obj.modifiers if modifier.type == 'ARMATURE'} | {obj.parent}
    bones = [bone.name for each in rigs if each and each.type == 'ARMATURE' for bone in each.data.bones]
    group = obj.vertex_groups.new(name=unused(name, {*obj.vertex_groups.keys(), *bones}))
    _known(obj)[group.name, group.index] = np.empty(0, np.int32), np.empty(0, np.float32)
    return group


def unused(name, taken):
    """`name`, numbered where it is `taken`."""
    numbered = (f"{name[: ids.NAME_LENGTH - 4]}.{number:03}" for number in itertools.count(1))
    return name if name not in taken else next(each for each in numbered if each not in taken)


def remove_made(obj, name):
    """Deletes a group that the add-on made, if no other object with the mesh uses it. The active one stays active."""
    others = (other.meanvalue for other in shape_keys.sharing(obj))
    if name not in obj.vertex_groups or any(name in each.handles or name == each.roi_group for each in others):
        return
    active = active_name(obj)
    _known(obj).clear()
    obj.vertex_groups.remove(obj.vertex_groups[name])
    make_active(obj, active)


def replace_weights(obj, group, weights):
    """The group gets the vertices of n `weights` above 0, in steps of 1/WEIGHT_STEPS, and loses all others."""
    levels = np.ceil(np.clip(weights, 0.0, 1.0) * WEIGHT_STEPS - 1e-3).astype(np.int32)
    numbers, before = np.flatnonzero(levels).astype(np.int32), _known(obj).get((group.name, group.index))
    order = numbers[np.argsort(levels[numbers], kind="stable")]
    ends = np.searchsorted(levels[order], np.arange(WEIGHT_STEPS + 1), side="right")
    group.remove(range(len(levels)) if before is None else before[0].tolist())
    for level in range(1, WEIGHT_STEPS + 1):
        members = order[ends[level - 1] : ends[level]]
        if len(members):
            group.add(members.tolist(), level / WEIGHT_STEPS, 'REPLACE')
    _known(obj)[group.name, group.index] = numbers, (levels[numbers] / WEIGHT_STEPS).astype(np.float32)
    obj.data.update_tag()


def slider_of(obj, key):
    """The Slider of a shape key of `obj`. A vertex group that is gone masks nothing, as in Blender."""
    group = key.vertex_group if key.vertex_group in obj.vertex_groups else ""
    return Slider(key.name, key.slider_min, key.slider_max, key.relative_key.name, group)


def shapes_of(obj, sliders, left_alone=()):
    """The KeyShapes of `sliders`. @throws SceneError."""
    rest = shape_keys.rest_positions(obj.data)
    require_finite(rest, "rest shape")
    points = {name: shape_keys.checked(obj, name) for each in sliders for name in (each.name, each.relative)}
    masks = weights(obj, {each.group for each in sliders})
    return KeyShapes(tuple(sliders), rest, points, masks, tuple(left_alone))


def key_shapes(found):
    """As of a Kind of reading, for what has the rest shape and points of a KeyShapes."""
    return [("", found.rest), *found.points.items()]
