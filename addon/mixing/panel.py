# SPDX-License-Identifier: GPL-3.0-or-later
"""Rotation-Aware Keys below Blender's own list of shape keys, in Properties."""

import bpy

from .. import wording
from ..live import engine
from ..scene import mirrors, subject
from ..widgets.panels import column_of_settings, draw_wrapped
from .bridge import mixed_keys
from .operators import MEANVALUE_OT_bake_mix, MEANVALUE_OT_morph


class MEANVALUE_PT_mix(bpy.types.Panel):
    """Shape keys that turn instead of shrinking along straight lines, and keys that stand for them elsewhere"""

    bl_space_type = 'PROPERTIES'
    bl_region_type = 'WINDOW'
    bl_context = "data"
    bl_parent_id = "DATA_PT_shape_keys"
    bl_label = "Rotation-Aware Keys"

    @classmethod
    def poll(cls, context):
        return subject.object_problem(subject.of(context)) is None

    def draw_header(self, context):
        self.layout.prop(subject.of(context).meanvalue.mix, "is_on", text="")

    def draw(self, context):
        layout, obj = self.layout, subject.of(context)
        if obj.meanvalue.mix.is_on:
            text, is_problem = engine.status(obj) or ("", False)
            problems = [text] if is_problem else mirrors.notes(obj)
            for problem in problems[:1]:
                draw_wrapped(layout, context, wording.sentence(problem), icon='ERROR')
        column = layout.column(align=True)
        column.operator(MEANVALUE_OT_morph.bl_idname, icon='ADD').part = ""
        group = obj.vertex_groups.active
        part = column.operator(MEANVALUE_OT_morph.bl_idname, text="Blend Part of Selected", icon='GROUP_VERTEX')
        part.part = "Group" if group is None else group.name
        column_of_settings(layout).prop(obj.meanvalue.mix, "tolerance_share")
        layout.operator(MEANVALUE_OT_bake_mix.bl_idname, icon='REC')
        if mixed_keys.in_between_names(obj):
            layout.operator(MEANVALUE_OT_bake_mix.bl_idname, text="Remove In-Betweens", icon='X').remove = True
