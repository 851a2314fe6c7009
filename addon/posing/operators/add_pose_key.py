# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the shape key in which the artist moves the anchors."""

import bpy

from ...scene import shape_keys
from ...widgets.base import MeshOperator


class MEANVALUE_OT_add_pose_key(MeshOperator, bpy.types.Operator):
    """Add a shape key in the rest shape and make it active, to move the vertices of handles in Edit Mode"""

    bl_idname = "meanvalue.add_pose_key"
    bl_label = "Add Pose Key"

    def run(self, obj):
        name = shape_keys.add_pose_key(obj)
        return f"Shape key '{name}' is active: move the vertices of handles in Edit Mode, then Solve", []
