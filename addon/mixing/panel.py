# SPDX-License-Identifier: GPL-3.0-or-later
"""Rotation-Aware Keys below Blender's own list of shape keys, in Properties."""

import bpy

from .. import wording
from ..live import engine
from ..scene import subject
from ..widgets.panels import column_of_settings, draw_wrapped
from .bridge import in_between_keys, mixed_keys
from .operators import morph
from .operators.bake_mix import MEANVALUE_OT_bake_mix


class _ShapeKeysPanel:
    bl_space_type = 'PROPERTIES'
    bl_region_type = 'WINDOW'
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return subject.object_problem(context.object) is None


class MEANVALUE_PT_mix(_ShapeKeysPanel, bpy.types.Panel):
    """Shape keys that turn instead of shrinking along straight lines"""

    bl_parent_id = "DATA_PT_shape_keys"
    bl_label = "Rotation-Aware Keys"

    def draw_header(self, context):
        self.layout.prop(context.object.meanvalue.mix, "is_on", text="")

    def draw(self, context):
        problem = _problem(context.object)
        if problem:
            draw_wrapped(self.layout, context, wording.sentence(problem), icon='ERROR')
        morph.draw_buttons(self.layout.column(align=True), context)


class MEANVALUE_PT_in_betweens(_ShapeKeysPanel, bpy.types.Panel):
    """Shape keys that stand for the mix, so that it plays without the add-on"""

    bl_parent_id = "MEANVALUE_PT_mix"
    bl_label = "In-Between Keys"
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        layout, obj = self.layout, context.object
        column_of_settings(layout).prop(obj.meanvalue.mix, "tolerance_share")
        layout.operator(MEANVALUE_OT_bake_mix.bl_idname, icon='REC')
        made = mixed_keys.in_between_names(obj)
        if made:
            layout.label(text=wording.counted(len(made), "in-between key"), icon='CHECKMARK')
            layout.operator(MEANVALUE_OT_bake_mix.bl_idname, text="Remove In-Betweens", icon='X').remove = True


def _problem(obj):
    """Why what is to be seen is not the mix that was asked for, or None."""
    problem = in_between_keys.problem(obj)
    if problem is None and obj.meanvalue.mix.is_on:
        text, is_problem = engine.status(obj) or ("", False)
        problem = text if is_problem else None
    return problem


CLASSES = (MEANVALUE_PT_mix, MEANVALUE_PT_in_betweens)
