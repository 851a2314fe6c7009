# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the pose the rest shape."""

import bpy

from ...live import engine
from ...scene import new_rest, subject
from ..bridge import bound_record, controls
from .settled import SettledOperator, unposed_problem


class MEANVALUE_OT_apply_pose(SettledOperator, bpy.types.Operator):
    """Make the pose the new rest shape, to pose on from there. Other shape keys are carried along"""

    bl_idname = "meanvalue.apply_pose"
    bl_label = "Apply as Rest"

    @classmethod
    def problem(cls, obj):
        return super().problem(obj) or unposed_problem(obj)

    def use(self, obj):
        handles = [handle for handle in obj.meanvalue.handles if handle.control is not None]
        controls.require_places(obj, handles)  # throws before anything is changed
        engine.look_again(obj)
        notes = new_rest.become(obj)
        bound_record.clear(obj.meanvalue.bound)
        controls.attach_where_they_are(obj, handles)
        if subject.sharing_note(obj):
            notes.append(subject.sharing_note(obj))
        return "The pose is the rest shape now", notes
