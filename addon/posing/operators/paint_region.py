# SPDX-License-Identifier: GPL-3.0-or-later
"""Paints the region of influence in Weight Paint Mode."""

import bpy

from ...scene import selection, subject
from ...widgets.base import MeshOperator
from ..bridge import region


class MEANVALUE_OT_paint_region(MeshOperator, bpy.types.Operator):
    """Paint the region: what has a weight may move. Press again when it is right"""

    bl_idname = "meanvalue.paint_region"
    bl_label = "Paint Region"
    needs_object_mode = False

    @classmethod
    def problem(cls, obj):
        is_painting = obj is not None and obj.mode == 'WEIGHT_PAINT'
        problem = super().problem(obj) or (None if is_painting else subject.mode_problem(obj))
        if problem is None and not obj.visible_get():
            problem = f"'{obj.name}' is hidden, so it cannot be painted. Show it first"
        return problem

    def run(self, obj):
        if obj.mode == 'WEIGHT_PAINT':
            bpy.ops.object.mode_set(mode='OBJECT')
            return "The region is painted", []
        region.require_own_group(obj)
        group = region.ensure_group(obj)
        obj.vertex_groups.active_index = group.index
        selection.choose(obj)
        bpy.ops.object.mode_set(mode='WEIGHT_PAINT')
        return f"Paint region '{group.name}': what has a weight may move. Press Paint Region again when it is right", []
