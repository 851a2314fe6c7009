# SPDX-License-Identifier: GPL-3.0-or-later
"""The part of the sidebar about mixing shape keys."""

import bpy

from .. import wording
from ..live import engine
from ..scene import subject
from ..widgets.panels import PanelPart
from ..widgets.text_box import draw_wrapped
from .bridge import in_between_keys, mix_layers
from .operators.bake_mix import MEANVALUE_OT_bake_mix
from .operators.morph import MEANVALUE_OT_blend_part, MEANVALUE_OT_morph
from .operators.remove_in_betweens import MEANVALUE_OT_remove_in_betweens

#: Sliders that are listed; a face may have hundreds, which Blender's own list has room for.
MOST_SLIDERS = 20


class MEANVALUE_PT_mix(PanelPart, bpy.types.Panel):
    """Shape keys that turn instead of shrinking along straight lines"""

    bl_label = "Shape Mix"
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        layout = self.layout
        obj = subject.of(context)
        settings = obj.meanvalue.mix
        switch = layout.row()
        switch.scale_y = 1.4
        switch.prop(settings, "is_on", toggle=True, icon='MOD_SIMPLEDEFORM')
        row = layout.row(align=True)
        row.operator(MEANVALUE_OT_morph.bl_idname, icon='ADD')
        row.operator(MEANVALUE_OT_blend_part.bl_idname, icon='GROUP_VERTEX')
        problem = mix_layers.problem(obj)
        if problem:
            draw_wrapped(layout, context, wording.sentence(problem), icon='INFO')
        else:
            _draw_mixing(layout, context, obj)
        _draw_in_betweens(layout, context, obj)


def _draw_mixing(layout, context, obj):
    settings = obj.meanvalue.mix
    _draw_sliders(layout, obj)
    if settings.is_on:
        _draw_status(layout, context, obj)
    column = layout.column(align=True)
    column.use_property_split = True
    column.use_property_decorate = False
    column.prop(settings, "tolerance_share")
    column.prop(settings, "most_keys")
    bake = layout.column()
    bake.scale_y = 1.4
    bake.operator(MEANVALUE_OT_bake_mix.bl_idname, icon='REC')


def _draw_in_betweens(layout, context, obj):
    made = mix_layers.made_names(obj)
    if not made:
        return
    problem = in_between_keys.problem(obj)
    text = problem or obj.meanvalue.mix.note or wording.counted(len(made), "in-between key")
    draw_wrapped(layout, context, wording.sentence(text), icon='ERROR' if problem else 'CHECKMARK')
    layout.operator(MEANVALUE_OT_remove_in_betweens.bl_idname, icon='X')


def _draw_sliders(layout, obj):
    column = layout.column(align=True)
    layers = mix_layers.taking_part(obj)
    for key in layers[:MOST_SLIDERS]:
        column.prop(key, "value", text=key.name, translate=False, slider=True)
    if len(layers) > MOST_SLIDERS:
        column.label(text=f"and {len(layers) - MOST_SLIDERS} more in Object Data Properties > Shape Keys")


def _draw_status(layout, context, obj):
    status = engine.status(obj)
    if status:
        text, is_problem = status
        draw_wrapped(layout.box(), context, text, icon='ERROR' if is_problem else 'PLAY')


CLASSES = (MEANVALUE_PT_mix,)
