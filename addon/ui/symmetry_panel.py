# SPDX-License-Identifier: GPL-3.0-or-later
"""The part of the sidebar about posing both sides at once."""

import bpy

from ..bridge import mirrors, scene_input
from ..core import wording
from ..operators.select_unpaired import MEANVALUE_OT_select_unpaired
from .panel import PanelPart
from .text_box import draw_wrapped


class MEANVALUE_PT_symmetry(PanelPart, bpy.types.Panel):
    """What is posed on both sides at once"""

    bl_label = "Symmetric"

    def draw(self, context):
        layout = self.layout
        obj = scene_input.subject(context)
        row = layout.row(align=True)
        row.prop(obj.meanvalue, "symmetric", expand=True)
        if obj.meanvalue.symmetric != 'NONE':
            layout.operator(MEANVALUE_OT_select_unpaired.bl_idname, icon='RESTRICT_SELECT_OFF')
        for note in mirrors.notes(obj):
            draw_wrapped(layout, context, wording.sentence(note), icon='MOD_MIRROR')


CLASSES = (MEANVALUE_PT_symmetry,)
