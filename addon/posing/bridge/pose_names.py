# SPDX-License-Identifier: GPL-3.0-or-later
"""What poses, handles and pins are called that nobody has named: by the bone, group or side where they are."""

import collections

import numpy as np

#: Of the mesh's size: what is nearer to the middle is on neither side.
MIDDLE = 0.02

#: So many vertices say where a handle is.
SAMPLES = 50


def of(obj, offsets):
    """Of what n x 3 `offsets` move farthest: "Hand.L Pose"."""
    return named(obj, [int(np.square(offsets).sum(axis=1).argmax())], "Pose")


def named(obj, vertices, kind):
    """Of a `kind` of thing that has these vertices: "Hand.L Handle", "Left Pin"."""
    settings, weights = obj.meanvalue, collections.Counter()
    made = {settings.made_region, settings.roi_group, *(handle.made_group for handle in settings.handles)}
    chosen = [obj.data.vertices[int(vertex)] for vertex in vertices[:: 1 + len(vertices) // SAMPLES]]
    for each in (element for vertex in chosen for element in vertex.groups):
        name = obj.vertex_groups[each.group].name
        weights[name] += each.weight if name not in made else 0.0
    dominant, weight = max(weights.items(), key=lambda item: item[1], default=("", 0.0))
    across, size = np.mean([vertex.co.x for vertex in chosen]), np.linalg.norm(np.ptp(np.array(obj.bound_box), axis=0))
    side = "" if abs(across) <= MIDDLE * size else "Left" if across > 0.0 else "Right"
    return f"{dominant if weight > 0.0 else side} {kind}".strip()
