# SPDX-License-Identifier: GPL-3.0-or-later
"""What poses, handles and pins are called that nobody has named: by the bone, group or side where they are."""

import collections

import numpy as np

from ...scene import rig_space

#: Of the mesh's size: what is nearer to the middle is on neither side.
MIDDLE = 0.02

#: So many vertices say where a handle is.
SAMPLES = 50


def of(obj, offsets):
    """Of what n x 3 `offsets` move at least half as far as any: "Hand.L Pose"."""
    squares = np.square(offsets).sum(axis=1)
    return named(obj, np.flatnonzero(squares >= 0.25 * squares.max()), "Pose")


def named(obj, vertices, kind):
    """Of a `kind` of thing that has these vertices: "Hand.L Handle", "Left Pin"."""
    settings, weights = obj.meanvalue, collections.Counter()
    made = {settings.made_region, settings.roi_group, *(handle.made_group for handle in settings.handles)}
    chosen = [obj.data.vertices[int(vertex)] for vertex in vertices[:: 1 + len(vertices) // SAMPLES]]
    for each in (element for vertex in chosen for element in vertex.groups):
        name = obj.vertex_groups[each.group].name
        weights[name] += each.weight if name not in made else 0.0
    across, size = np.mean([vertex.co.x for vertex in chosen]), np.linalg.norm(np.ptp(np.array(obj.bound_box), axis=0))
    side = "" if abs(across) <= MIDDLE * size else "Left" if across > 0.0 else "Right"
    return f"{_most_of(obj, +weights) or side} {kind}".strip()


def _most_of(obj, weights):
    """The deepest bone that carries, with those below it, more than half of the weight: a hand, not one of its fingers.
    Without bones the group that has most; "" without groups."""
    rig, carried = rig_space.armature(obj), collections.Counter()
    for bone in [] if rig is None else [each for each in rig.data.bones if each.name in weights]:
        carried.update(dict.fromkeys([each.name for each in (bone, *bone.parent_recursive)], weights[bone.name]))
    deep = [name for name, weight in carried.items() if 2.0 * weight > max(carried.values())]  # one below the other
    return min(deep, key=carried.get, default=max(weights, key=weights.get, default=""))
