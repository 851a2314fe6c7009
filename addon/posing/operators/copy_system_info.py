# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies what a report of a bug should say."""

import bpy

from ...scene import subject
from ...widgets.base import Reporting
from ..core import system_info
from . import system_facts


class MEANVALUE_OT_copy_system_info(Reporting, bpy.types.Operator):
    """Copy versions, counts, settings and the last message to the clipboard, for reports of bugs. No names, no paths"""

    bl_idname = "meanvalue.copy_system_info"
    bl_label = "Copy System Info"
    bl_options = {'REGISTER'}

    def execute(self, context):
        text = system_info.text(system_facts.sections(subject.of(context)))
        context.window_manager.clipboard = text
        if bpy.app.background:  # which has no clipboard
            print(text)
        self.report({'INFO'}, "Copied. Paste it into the report.")
        return {'FINISHED'}
