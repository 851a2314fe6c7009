# SPDX-License-Identifier: GPL-3.0-or-later
"""What a pose is called when nobody has given it a name."""

import numpy as np

from ...scene import shape_keys
from ...scene.core import fixed_points

#: Of the mesh's size: what is nearer to the middle is on neither side.
MIDDLE = 0.05


def of(obj, offsets):
    """By the bone, group or side of what n x 3 `offsets` move farthest: "Hand.L Pose"."""
    vertex, rest = int(np.square(offsets).sum(axis=1).argmax()), shape_keys.rest_positions(obj.data)
    made = {obj.meanvalue.made_region, *(handle.made_group for handle in obj.meanvalue.handles)}
    groups = [(each.weight, obj.vertex_groups[each.group].name) for each in obj.data.vertices[vertex].groups]
    named = [(weight, name) for weight, name in groups if weight > 0.0 and name not in made]
    across = rest[vertex, 0] / fixed_points.bounding_box_diagonal(rest)
    side = "" if abs(across) < MIDDLE else "Left" if across > 0.0 else "Right"
    return f"{max(named)[1] if named else side} Pose".strip()
