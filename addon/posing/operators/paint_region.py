# SPDX-License-Identifier: GPL-3.0-or-later
"""Paints the region of influence in Weight Paint Mode."""

import bpy

from ...errors import SceneError
from ...scene import selection, subject
from ...widgets.base import MeshOperator
from ..bridge import region


class MEANVALUE_OT_paint_region(MeshOperator, bpy.types.Operator):
    """Paint the region of influence: what has a weight belongs to it. Its vertex group is made if it is missing"""

    bl_idname = "meanvalue.paint_region"
    bl_label = "Paint Region"

    def run(self, obj):
        region.require_own_group(obj)
        if not obj.visible_get():
            raise SceneError(f"'{obj.name}' is hidden, so it cannot be painted. Show it first")
        group = region.ensure_group(obj)
        obj.vertex_groups.active_index = group.index
        selection.choose(obj)
        bpy.ops.object.mode_set(mode='WEIGHT_PAINT')
        return f"Paint the region '{group.name}': what has a weight may move. Press Done when it is right", []


class MEANVALUE_OT_finish_region(MeshOperator, bpy.types.Operator):
    """Go back to Object Mode from painting the region"""

    bl_idname = "meanvalue.finish_region"
    bl_label = "Done"
    needs_object_mode = False

    @classmethod
    def problem(cls, obj):
        problem = super().problem(obj)
        if problem is None and obj.mode != 'WEIGHT_PAINT':
            problem = f"'{obj.name}' is in {subject.mode_name(obj.mode)}, so nothing is being painted"
        return problem

    def run(self, obj):
        bpy.ops.object.mode_set(mode='OBJECT')
        return f"'{obj.name}' is in Object Mode again", []
