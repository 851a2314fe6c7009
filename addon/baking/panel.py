# SPDX-License-Identifier: GPL-3.0-or-later
"""The part of the sidebar about baking, and what is on top of all while a bake plays."""

import bpy

from ..scene import subject
from ..scene.baked import TO_BONES, TO_CACHE, TO_KEYS
from ..widgets.panels import PanelPart, column_of_settings, draw_main_button, draw_range, draw_wrapped
from .bridge import preparing
from .operators import MEANVALUE_OT_bake, MEANVALUE_OT_unbake


class MEANVALUE_PT_bake(PanelPart, bpy.types.Panel):
    """What becomes of the animation of the handles"""

    bl_label = "Bake"

    def draw(self, context):
        layout = column_of_settings(self.layout)
        obj = subject.of(context)
        settings = obj.meanvalue.bake
        layout.prop(settings, "target")
        of_bones = ["bones", *["tolerance_share"][settings.bones :], "influences", "skeleton", "root_bone"]
        of_bones = ["armature", *(["its_motion", "influences"] if settings.armature else of_bones)]
        for name in {TO_CACHE: ["path"], TO_KEYS: ["tolerance_share"], TO_BONES: of_bones}[settings.target]:
            layout.prop(settings, name)
        if settings.target == TO_CACHE and not settings.path:
            layout.label(text=preparing.default_path(obj))
        draw_range(layout, settings)
        layout.prop(settings, "samples")
        draw_main_button(layout, MEANVALUE_OT_bake, 'REC')


def draw_top(layout, context, obj):
    """On top of the main panel. Returns whether the rest of it is not to be drawn."""
    record = obj.meanvalue.baked
    if not record.target:
        return False
    layout.label(text="A bake plays", icon='PLAY')
    draw_wrapped(layout, context, record.note)
    if record.worst:
        row = layout.operator("meanvalue.select_problems", text="Select Worst Vertices", icon='RESTRICT_SELECT_OFF')
        row.kind = 'BAKED'
    layout.operator(MEANVALUE_OT_unbake.bl_idname, icon='X')
    if obj.meanvalue.handles:
        layout.operator(MEANVALUE_OT_unbake.bl_idname, text="Keep Bake, Remove Handles").keep_bake = True
    return True
