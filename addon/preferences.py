# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on's entry in Preferences: whether the compiled solver is there, the guide, and what a report needs."""

import bpy

from . import manual, wording
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
        row = self.layout.row()
        row.operator("wm.url_open", text="Documentation", icon='HELP').url = manual.START
        row.operator("meanvalue.copy_system_info", text="Copy System Info for a Bug Report", icon='URL')
