# SPDX-License-Identifier: GPL-3.0-or-later
"""Members of vertex groups. A vertex is a member if its weight is above zero."""

import array
import itertools
import math
import time

import numpy as np

from .. import ids
from ..errors import SceneError
from . import shape_keys

#: Vertices that are read before the clock is looked at: some 5 ms with four groups at each.
SLICE = 5000

#: Weights that the add-on writes have this many steps, as many as Blender has colors for painted ones.
WEIGHT_STEPS = 255


class Reading:
    """The weights of groups, read a slice of the vertices at a time, so that nobody has to wait for a big mesh.

    Blender has no bulk access to weights, so this is the slow part of reading a scene: 10 ms for 50,000 vertices, 40 ms
    where each is in five groups. Nothing of Blender's is kept: the object is handed in for each slice. What was read
    is worth nothing once the object was edited.
    """

    def __init__(self, obj, names):
        self._indices = {name: obj.vertex_groups[name].index for name in names if name in obj.vertex_groups}
        self._found = {index: (array.array("i"), array.array("f")) for index in self._indices.values()}
        self.vertex_count = len(obj.data.vertices)
        self._next = 0 if self._found else self.vertex_count

    def go_on(self, obj, seconds=math.inf):
        """Reads for about so long, a slice in any case. Returns whether all is read."""
        until = time.monotonic() + seconds
        vertices, found = obj.data.vertices, self._found
        while self._next < self.vertex_count:
            for number, vertex in enumerate(vertices[self._next : self._next + SLICE], self._next):
                for element in vertex.groups:
                    if element.group in found:
                        numbers, weights = found[element.group]
                        numbers.append(number)
                        weights.append(element.weight)
            self._next += SLICE
            if time.monotonic() >= until:
                break
        return self._next >= self.vertex_count

    @property
    def members(self):
        """{name: ascending vertex indices, int32} of the groups that exist."""
        found = {name: [np.array(each) for each in self._found[index]] for name, index in self._indices.items()}
        return {name: numbers[weights > 0.0].astype(np.int32) for name, (numbers, weights) in found.items()}

    @property
    def weights(self):
        """{name: n float64, 0 to 1} of the groups that exist."""
        result = {name: np.zeros(self.vertex_count) for name in self._indices}
        for name, index in self._indices.items():
            numbers, weights = self._found[index]
            result[name][np.array(numbers, np.int32)] = weights
        return result


def weights(obj, names):
    """{name: n float64, 0 to 1} of the groups that exist, all read in one pass over the vertices."""
    reading = Reading(obj, names)
    reading.go_on(obj)
    return reading.weights


def members(obj, names):
    """{name: ascending vertex indices, int32} of the groups that exist, all read in one pass over the vertices."""
    reading = Reading(obj, names)
    reading.go_on(obj)
    return reading.members


def full_members(obj, name):
    """Indices of the vertices with the group's largest weight: without those that subdividing made between them and
    others."""
    found = weights(obj, [name]).get(name, np.zeros(1))
    return np.flatnonzero((found > 0.0) & (found > found.max(initial=0.0) - 1e-6)).astype(np.int32)


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
    """A new vertex group, called so, or numbered where that is taken or names a bone.

    The weights of a group that is called like a bone of the mesh's armature are that bone's skin: a handle or a region
    of that name would move with the bone.
    """
    return obj.vertex_groups.new(name=unused(name, {*obj.vertex_groups.keys(), *_bone_names(obj)}))


def unused(name, taken):
    """`name`, numbered where it is `taken`."""
    numbered = (f"{name[: ids.NAME_LENGTH - 4]}.{number:03}" for number in itertools.count(1))
    return name if name not in taken else next(each for each in numbered if each not in taken)


def _bone_names(obj):
    """Names of the bones of all armatures that deform the object."""
    armatures = {modifier.object for modifier in obj.modifiers if modifier.type == 'ARMATURE'} | {obj.parent}
    return [bone.name for each in armatures if each and each.type == 'ARMATURE' for bone in each.data.bones]


def remove_made(obj, name):
    """Deletes a group that the add-on made. The active one stays active.

    Objects with the same mesh share its groups, so one that another of them uses stays.
    """
    if name not in obj.vertex_groups or _is_used_by_another(obj, name):
        return
    active = active_name(obj)
    obj.vertex_groups.remove(obj.vertex_groups[name])
    make_active(obj, active)


def _is_used_by_another(obj, name):
    """Whether another object with the same mesh has the group as a handle or region."""
    others = (other.meanvalue for other in shape_keys.sharing(obj))
    return any(name in settings.handles or name == settings.roi_group for settings in others)


def replace_weights(obj, group, weights):
    """The group gets the vertices of n `weights` above 0, in steps of 1/WEIGHT_STEPS, and loses all others.

    Blender takes many vertices of one weight at a time.
    """
    levels = np.ceil(np.clip(weights, 0.0, 1.0) * WEIGHT_STEPS - 1e-3).astype(np.int32)
    order = np.argsort(levels, kind="stable")
    ends = np.searchsorted(levels[order], np.arange(WEIGHT_STEPS + 1), side="right")
    group.remove(range(len(levels)))
    for level in range(1, WEIGHT_STEPS + 1):
        members = order[ends[level - 1] : ends[level]]
        if len(members):
            group.add(members.tolist(), level / WEIGHT_STEPS, 'REPLACE')
    obj.data.update_tag()
