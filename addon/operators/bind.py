# SPDX-License-Identifier: GPL-3.0-or-later
"""Binds the rest shape, the anchors and the region."""

import bpy

from .. import session
from ..bridge import bound_record, mesh_arrays, scene_input
from ..core import result
from .base import MeshOperator


class MEANVALUE_OT_bind(MeshOperator, bpy.types.Operator):
    """Encode the rest shape for its anchors and region. Do it once, then pose and solve as often as you like"""

    bl_idname = "meanvalue.bind"
    bl_label = "Bind"

    def run(self, obj):
        bind_input = scene_input.gather(obj)
        binding = session.binding_for(bind_input, lambda: mesh_arrays.triangles(obj.data, bind_input))
        bound_record.write(obj.meanvalue.bound, bind_input.fingerprint, binding.summary)
        report = binding.deformer.report
        notes = [*result.guarded_notes(report), *result.size_notes(report)]
        message = ". ".join([f"Bound {binding.summary.text()}", *notes])
        return message, list(binding.summary.notes())
