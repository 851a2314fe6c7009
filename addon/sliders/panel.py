# SPDX-License-Identifier: GPL-3.0-or-later
"""The part of the sidebar about values of shape keys."""

import bpy

from .. import wording
from ..scene import rig_space, subject
from ..widgets.panels import PanelPart, column_of_settings, draw_main_button, draw_range, draw_wrapped
from .bridge import driven_keys, key_shapes
from .bridge.head_motion import ON_BONE
from .operators import MEANVALUE_OT_add_corrective, MEANVALUE_OT_bake_values, MEANVALUE_OT_import_values


class MEANVALUE_PT_sliders(PanelPart, bpy.types.Panel):
    """Values of the shape keys that the mesh has: by hand, and from a file"""

    bl_label = "Shape Key Values"

    def draw(self, context):
        layout, obj = column_of_settings(self.layout), subject.of(context)
        layout.prop(obj.meanvalue, "drive")
        problem = key_shapes.problem(obj) if driven_keys.is_on(obj) else None
        if problem:
            draw_wrapped(layout, context, wording.sentence(problem), icon='ERROR')
        if driven_keys.is_on(obj):
            layout.operator(MEANVALUE_OT_add_corrective.bl_idname, icon='SHAPEKEY_DATA')
        layout.operator(MEANVALUE_OT_import_values.bl_idname, icon='IMPORT')


class MEANVALUE_PT_bake_values(PanelPart, bpy.types.Panel):
    """Values of the shape keys with which the mesh follows its animated handles, or markers"""

    bl_parent_id = MEANVALUE_PT_sliders.__name__
    bl_label = "From Handles or Markers"

    def draw(self, context):
        layout, obj = column_of_settings(self.layout), subject.of(context)
        settings = obj.meanvalue.bake_values
        layout.prop(settings, "source")
        if settings.source == 'MARKERS':
            draw_wrapped(layout, context, "Take, Reference Frame and picked points are those of Motion Capture")
        layout.prop(settings, "head_motion")
        rig = rig_space.armature(obj) if settings.head_motion == ON_BONE else None
        if rig is not None:
            layout.prop_search(settings, "bone", rig.pose, "bones")
        draw_range(layout, settings)
        layout.prop(settings, "tolerance")
        layout.prop(settings, "replace")
        draw_main_button(layout, MEANVALUE_OT_bake_values, 'REC')
