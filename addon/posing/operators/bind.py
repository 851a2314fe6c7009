# SPDX-License-Identifier: GPL-3.0-or-later
"""Binds the rest shape, the anchors and the region."""

import bpy

from ... import wording
from ...scene import vertex_groups
from ...solver.core import result
from ...widgets.background import BackgroundOperator
from ..bridge import bound_record, controls, new_handles, scene_input, targets
from ..bridge.posing import Posing


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

    def finish(self, obj, posing, _outcome):
        handles = [handle for handle in targets.enabled_handles(obj) if handle.follows == 'CONTROL']
        handles = [handle for handle in handles if controls.problem(obj, handle) is None]
        controls.require_places(obj, handles)  # throws before anything is changed
        if _has_other_rest_shape(obj, posing):
            controls.attach_where_they_are(obj, handles, [controls.shown_move(obj, handle) for handle in handles])
        controls.remove_deleted(obj)
        made = _make_own_controls(obj)
        posing.record(obj)
        notes = [f"{wording.counted(made, 'control')} made"] if made else []
        notes += result.size_notes(posing.binding.deformer.report)
        message = ". ".join([f"Updated: {posing.binding.summary.text()}", *notes])
        return message, list(posing.binding.summary.notes())


def _make_own_controls(obj):
    """For handles whose control is missing or belongs to another object, as after duplicating. Returns how many."""
    handles = [handle for handle in targets.enabled_handles(obj) if handle.follows == 'CONTROL']
    handles = [handle for handle in handles if controls.wants_own_control(obj, handle)]
    members = vertex_groups.members(obj, [handle.name for handle in handles])
    for handle in handles:
        new_handles.make_handle(obj, handle, members[handle.name], handle.color)
    return len(handles)


def _has_other_rest_shape(obj, posing):
    """Whether the rest shape is another than the one that was bound (edited, subdivided, scaled, origin set): the
    controls, which were not moved for that, then move their handles from where these are."""
    bound = bound_record.read_fingerprint(obj.meanvalue.bound)
    return bound is not None and bound.rest_shape != posing.bind_input.fingerprint.rest_shape
