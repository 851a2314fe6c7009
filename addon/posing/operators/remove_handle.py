# SPDX-License-Identifier: GPL-3.0-or-later
"""Removes a handle or pin, with what was made for it."""

import bpy

from ...scene import selection
from ...widgets.base import MeshOperator
from ..bridge import controls, region


class MEANVALUE_OT_remove_handle(MeshOperator, bpy.types.Operator):
    """Remove the active handle or pin, with the control and vertex group that were made for it"""

    bl_idname = "meanvalue.remove_handle"
    bl_label = "Remove Handle"
    needs_object_mode = False

    @classmethod
    def problem(cls, obj):
        problem = super().problem(obj)
        if problem is None and obj.meanvalue.active_handle >= len(obj.meanvalue.handles):
            problem = "No handle or pin is active. Click the one to remove in the list"
        return problem

    def run(self, obj):
        settings = obj.meanvalue
        index = settings.active_handle
        selection.leave_edit_mode(obj)
        name = settings.handles[index].name
        region.let_go(obj, settings.handles[index])
        controls.remove_handle(obj, index)
        return f"'{name}' holds nothing any more", []
