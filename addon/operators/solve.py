# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses the mesh by its anchors and writes the result as a shape key."""

import bpy

from .. import session
from ..bridge import bound_record, mesh_arrays, scene_input, shape_keys
from ..core import fingerprint, result
from ..errors import SceneError, StaleBindingError
from .base import MeshOperator


class MEANVALUE_OT_solve(MeshOperator, bpy.types.Operator):
    """Pose the mesh: anchors go where the active shape key has them, the rest follows, written as a shape key"""

    bl_idname = "meanvalue.solve"
    bl_label = "Solve"

    def run(self, obj):
        record = obj.meanvalue.bound
        if not record.is_bound:
            raise SceneError(f"'{obj.name}' is not bound yet. Press Bind first")
        bind_input = scene_input.gather(obj)
        rebound = _what_changed(record, bind_input.fingerprint)
        pose = shape_keys.pose_positions(obj)

        binding = session.binding_for(bind_input, lambda: mesh_arrays.triangles(obj.data, bind_input))
        solved, summary = session.solve(binding, bind_input, pose[bind_input.anchors])

        result_is_pose = obj.active_shape_key.name == obj.meanvalue.result_key
        warnings = [
            *binding.summary.notes(),
            *summary.notes(),
            *result.pose_warnings(bind_input, pose, result_is_pose),
        ]
        notes = shape_keys.write_result(obj, result.compose(bind_input, pose, solved))
        if rebound:
            bound_record.write(record, bind_input.fingerprint, binding.summary)
            notes.insert(0, f"Bound again, because {rebound}")
        bound_record.write_solve(record, summary)
        return _message(obj, summary, notes), warnings


def _what_changed(record, now):
    """What changed since bind that Solve may take in its stride, in words; "" if nothing.

    @throws StaleBindingError if the artist has to look first.
    """
    bound = bound_record.read_fingerprint(record)
    reasons = fingerprint.stale_reasons(bound, now)
    changes = fingerprint.describe(reasons, bound, now)
    if fingerprint.needs_bind(reasons):
        raise StaleBindingError(f"The binding is stale: {changes}. Check the anchors and press Bind")
    return changes


def _message(obj, summary, notes):
    shared = scene_input.sharing_note(obj)
    return ". ".join(
        [f"Solved into '{obj.meanvalue.result_key}': {summary.text()}", *notes, *([shared] if shared else [])]
    )
