# SPDX-License-Identifier: GPL-3.0-or-later
"""Binds the rest shape, the anchors and the region."""

import bpy

from ...scene import mesh_arrays
from ...solver.core import fingerprint, result
from ...widgets.background import BackgroundOperator
from ..bridge import bound_record, controls, scene_input, targets
from ..bridge.posing import Posing
from ..core import mesh_problems


class MEANVALUE_OT_bind(BackgroundOperator, bpy.types.Operator):
    """Encode the rest shape for its handles and region. Do it once, then pose as often as you like"""

    bl_idname = "meanvalue.bind"
    bl_label = "Bind"
    doing = "Binding"

    def start_reading(self, obj):
        return scene_input.start_reading(obj)

    def prepare(self, obj, reading):
        return Posing.to_bind(obj, reading)

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
        if _has_other_rest_shape(obj, posing):
            for handle in targets.enabled_handles(obj):
                if handle.follows == 'CONTROL' and controls.problem(obj, handle) is None:
                    controls.attach_as_shown(obj, handle, controls.shown_move(obj, handle))
        posing.record(obj)
        report = posing.binding.deformer.report
        guarded = result.guarded_notes(report, posing.bind_input.solver_mesh.places)
        notes = [*mesh_problems.text(self._problems), *guarded, *result.size_notes(report)]
        bound = f"Bound {posing.binding.summary.text()}"
        message = ". ".join([bound, *notes])
        return message, list(posing.binding.summary.notes())


def _has_other_rest_shape(obj, posing):
    """Whether the rest shape is another than the one that was bound (edited, scale applied, origin set): the controls,
    which were not moved for that, then move their handles from where these are."""
    bound = bound_record.read_fingerprint(obj.meanvalue.bound)
    if bound is None:
        return False
    return fingerprint.StaleReason.REST_SHAPE in fingerprint.stale_reasons(bound, posing.bind_input.fingerprint)
