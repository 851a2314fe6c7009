# SPDX-License-Identifier: GPL-3.0-or-later
"""The part of the sidebar about values of shape keys."""

import bpy

from ..widgets.panels import PanelPart
from .operators.import_values import MEANVALUE_OT_import_values


class MEANVALUE_PT_sliders(PanelPart, bpy.types.Panel):
    """Values of the shape keys that the mesh has, from files"""

    bl_idname = "MEANVALUE_PT_sliders"
    bl_label = "Shape Key Values"
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, _context):
        self.layout.operator(MEANVALUE_OT_import_values.bl_idname, icon='IMPORT')


CLASSES = (MEANVALUE_PT_sliders,)
