# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on's entry in Preferences: whether the compiled solver is there, and what it has to fit."""

import bpy

from . import wording
from .solver import native_loader
from .widgets import panels


class MEANVALUE_AP_preferences(bpy.types.AddonPreferences):  # noqa: N801  Blender's way
    bl_idname = __package__

    def draw(self, context):
        box = self.layout.box()
        box.label(text="Solver")
        problem = native_loader.problem()
        if problem:
            panels.draw_wrapped(box, context, wording.sentence(problem), icon='ERROR')
        else:
            ready = f"Ready, version {native_loader.module().__version__}"
            box.label(text=ready, icon='CHECKMARK')
        box.operator("meanvalue.copy_system_info", icon='COPYDOWN')
