# SPDX-License-Identifier: GPL-3.0-or-later
"""The part of the sidebar about mirrors, where there are some. Symmetric itself is below Live."""

import bpy

from ... import wording
from ...scene import mirrors, subject
from ...widgets.panels import PanelPart
from ...widgets.text_box import draw_wrapped
from ..operators.select_unpaired import MEANVALUE_OT_select_unpaired


class MEANVALUE_PT_symmetry(PanelPart, bpy.types.Panel):
    """What has no mirror image, and which mirrors are left out"""

    bl_label = "Symmetric"

    @classmethod
    def poll(cls, context):
        obj = subject.of(context)
        return super().poll(context) and (obj.meanvalue.symmetric != 'NONE' or bool(mirrors.notes(obj)))

    def draw(self, context):
        layout = self.layout
        obj = subject.of(context)
        if obj.meanvalue.symmetric != 'NONE':
            layout.operator(MEANVALUE_OT_select_unpaired.bl_idname, icon='RESTRICT_SELECT_OFF')
        for note in mirrors.notes(obj):
            draw_wrapped(layout, context, wording.sentence(note), icon='MOD_MIRROR')


CLASSES = (MEANVALUE_PT_symmetry,)
