# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes the frame that is shown as the one in which the markers stand as the mesh does."""

import bpy

from ...widgets.base import MeshOperator


class MEANVALUE_OT_set_reference_frame(MeshOperator, bpy.types.Operator):
    """Take the current frame as the one in which the markers stand as the mesh does at rest"""

    bl_idname = "meanvalue.set_reference_frame"
    bl_label = "Use Current Frame"
    needs_object_mode = False

    def run(self, obj):
        frame = bpy.context.scene.frame_current_final
        obj.meanvalue.capture.reference_frame = frame
        return f"The markers stand as '{obj.name}' does in frame {frame:g}", []
