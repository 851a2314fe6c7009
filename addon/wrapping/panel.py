# SPDX-License-Identifier: GPL-3.0-or-later
"""The part of the sidebar about Wrap."""

import bpy

from ..scene import subject
from ..widgets.panels import PanelPart, column_of_settings, draw_main_button
from .bridge import wrap_scene
from .operators import MEANVALUE_OT_pick_wrap_pairs, MEANVALUE_OT_wrap


class MEANVALUE_PT_wrap(PanelPart, bpy.types.Panel):
    """Take the shape of a mesh that has other faces"""

    bl_label = "Wrap"

    def draw(self, context):
        layout = self.layout
        settings = subject.of(context).meanvalue.wrap
        column_of_settings(layout).prop(settings, "target")
        row = layout.row(align=True)
        row.operator(MEANVALUE_OT_pick_wrap_pairs.bl_idname, icon='EYEDROPPER')
        if settings.pairs:
            row.operator(MEANVALUE_OT_pick_wrap_pairs.bl_idname, text="", icon='X').clear = True
            layout.label(text=f"Pairs picked: {len(settings.pairs)}")
        draw_main_button(layout, MEANVALUE_OT_wrap, 'MOD_SHRINKWRAP')
        if wrap_scene.is_wrapped(settings.id_data):
            column = column_of_settings(layout)
            column.prop(settings, "keys")
            column.prop(settings, "replace")
            layout.operator(MEANVALUE_OT_wrap.bl_idname, text="Carry Shape Keys", icon='SHAPEKEY_DATA').carry = True
