# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits the mesh onto another one, whatever faces that has."""

import bpy

from ... import ids, wording
from ...scene import subject
from ...widgets.background import BackgroundOperator
from ..bridge import wrap_scene

#: Vertices that end farther away are put in a group, as a share of the other mesh's size.
LEFT_OVER = 0.005


class MEANVALUE_OT_wrap(BackgroundOperator, bpy.types.Operator):
    """Fit the mesh onto another one, which may have other faces: its shape becomes a shape key here"""

    bl_label = "Wrap Mesh"
    doing = "Wrapping"
    problems = (wrap_scene.target_problem, wrap_scene.pairs_problem)

    def prepare(self, obj):
        return wrap_scene.Wrapping(obj, wrap_scene.target_of(obj))

    def job_progress(self):
        return "fitting", self._prepared.share

    def finish(self, obj, prepared, wrapped):
        target = bpy.data.objects[prepared.target_name]
        size = prepared.given.diagonal
        name, left_over = wrap_scene.write(obj, target, wrapped, prepared.whole, LEFT_OVER * size)
        distance = wrapped.distance[prepared.given.used] / size
        notes = []
        if left_over:
            left = f"{wording.vertices(left_over)} are farther than {LEFT_OVER:.1%}"
            notes.append(f"{left}: they are in the vertex group '{ids.LEFT_OVER_GROUP}'. Pick more pairs there")
        if wrapped.flipped:
            flipped = wording.counted(wrapped.flipped, "triangle is", "triangles are")
            notes.append(f"{flipped} turned over. Pick pairs where they crowd")
        off = f"{distance.mean():.3%} of its size off on average, {distance.max():.2%} at most"
        message = f"'{obj.name}' has the shape of '{target.name}' as shape key '{name}': {off}"
        return message, [*notes, *subject.sharing_notes(obj)]
