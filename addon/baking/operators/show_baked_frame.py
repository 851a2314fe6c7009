# SPDX-License-Identifier: GPL-3.0-or-later
"""Goes to a frame of a bake that is worth a look."""

import math

import bpy
from bpy.props import FloatProperty

from ...widgets.base import MeshOperator


class MEANVALUE_OT_show_baked_frame(MeshOperator, bpy.types.Operator):
    """Go to this frame, which has one of the highest energies of the bake"""

    bl_idname = "meanvalue.show_baked_frame"
    bl_label = "Show Frame"
    needs_object_mode = False

    frame: FloatProperty(name="Frame", description="Where to go, with sub-frames", options={'SKIP_SAVE'})

    def run(self, _obj):
        whole = math.floor(self.frame)
        bpy.context.scene.frame_set(whole, subframe=self.frame - whole)
        return f"Frame {self.frame:g}", []
