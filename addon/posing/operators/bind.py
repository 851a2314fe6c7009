# SPDX-License-Identifier: GPL-3.0-or-later
"""Binds the rest shape, the anchors and the region."""

import bpy

from ... import wording
from ...scene import mesh_arrays, shape_keys, vertex_groups
from ...solver.core import result
from ...widgets.background import BackgroundOperator
from ..bridge import bound_record, controls, scene_input, targets
from ..bridge.posing import Posing
from ..core import mesh_problems


class MEANVALUE_OT_bind(BackgroundOperator, bpy.types.Operator):
    """Take the mesh as it was edited for the rest shape, and give handles without a control one of their own"""

    bl_idname = "meanvalue.bind"
    bl_label = "Update"
    doing = "Updating"

    @classmethod
    def problem(cls, obj):
        return super().problem(obj) or scene_input.unheld_problem(obj)

    def start_reading(self, obj):
        return scene_input.start_reading(obj)

    def prepare(self, obj, reading):
        return Posing(obj, reading, is_checked=False)

    def after(self, posing):
        """What is unusual about the mesh is counted in slices: all of it takes half a second for 200,000 vertices."""
        yield "looking at the mesh", 0.0
        rest = posing.bind_input.rest
        triangles = mesh_arrays.triangles(self._object().data, rest)
        search = mesh_problems.search(
            rest, triangles, posing.binding.deformer.report, posing.bind_input.solver_mesh.places
        )
        while True:
            try:
                yield "looking at the mesh", next(search)
            except StopIteration as end:
                self._problems = end.value
                return

    def finish(self, obj, posing, _outcome):
        handles = [handle for handle in targets.enabled_handles(obj) if handle.follows == 'CONTROL']
        handles = [handle for handle in handles if controls.problem(obj, handle) is None]
        controls.require_places(obj, handles)  # throws before anything is changed
        if _has_other_rest_shape(obj, posing):
            controls.attach_where_they_are(obj, handles, [controls.shown_move(obj, handle) for handle in handles])
        controls.remove_deleted(obj)
        made = _make_own_controls(obj)
        posing.record(obj)
        report = posing.binding.deformer.report
        problems, self._problems = self._problems, None  # Blender keeps the operator
        notes = [*mesh_problems.text(problems), *result.size_notes(report)]
        if made:
            notes.insert(0, f"{wording.counted(made, 'control')} made")
        message = ". ".join([f"Updated: {posing.binding.summary.text()}", *notes])
        return message, list(posing.binding.summary.notes())


def _make_own_controls(obj):
    """For handles whose control is missing or belongs to another object, as after duplicating. Returns how many."""
    handles = [handle for handle in targets.enabled_handles(obj) if handle.follows == 'CONTROL']
    handles = [handle for handle in handles if controls.wants_own_control(obj, handle)]
    rest, shown = shape_keys.rest_positions(obj.data), shape_keys.result_positions(obj)
    members = vertex_groups.members(obj, [handle.name for handle in handles])
    for handle in handles:
        own = members[handle.name]
        controls.add_control(obj, handle, rest[own], (rest if shown is None else shown)[own])
    return len(handles)


def _has_other_rest_shape(obj, posing):
    """Whether the rest shape is another than the one that was bound (edited, subdivided, scaled, origin set): the
    controls, which were not moved for that, then move their handles from where these are."""
    bound = bound_record.read_fingerprint(obj.meanvalue.bound)
    return bound is not None and bound.rest_shape != posing.bind_input.fingerprint.rest_shape
