# SPDX-License-Identifier: GPL-3.0-or-later
"""Has the mesh carried by the markers of a take."""

import bpy

from ..bridge import scene_input
from ..core import wording
from ..errors import SceneError
from ..workers import marker_matching
from .base import MeshOperator


class MEANVALUE_OT_match_markers(MeshOperator, bpy.types.Operator):
    """Lay the markers of the reference frame on the mesh, give each its point, and have soft handles follow them"""

    bl_idname = "meanvalue.match_markers"
    bl_label = "Match Markers"

    def run(self, obj):
        matched = marker_matching.match(obj)
        marker_matching.carry(obj, matched)
        notes = list(matched.notes)
        try:
            scene_input.gather(obj)
        except SceneError as problem:  # there is more to do before it can be posed
            notes.append(str(problem))
        return _account(obj, matched), notes


def _account(obj, matched):
    parts = [
        f"{wording.counted(len(matched.names), 'marker')} matched to '{obj.name}' at frame {matched.frame:g}, "
        f"{matched.distance.mean():.3g} from it on average, at most {matched.distance.max():.3g} "
        f"('{matched.names[int(matched.distance.argmax())]}')"
    ]
    filled = [f"{share:.1%} {how}" for how, share in matched.filled.items() if share]
    if filled:
        parts.append(f"Of the samples {wording.listed(filled)}")
    return ". ".join(parts)
