# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps the pose that is shown as a shape key of its own."""

import bpy

from ... import ids
from ...scene import shape_keys
from .settled import SettledOperator


class MEANVALUE_OT_keep_pose(SettledOperator, bpy.types.Operator):
    """Store the pose as a new shape key. Posing goes on in the result's own key"""

    bl_idname = "meanvalue.keep_pose"
    bl_label = "Keep Pose"

    name: bpy.props.StringProperty(
        name="Name", description="Name of the new shape key", default=ids.KEPT_KEY, maxlen=ids.NAME_LENGTH
    )

    def use(self, obj):
        name = shape_keys.keep(obj, self.name.strip() or ids.KEPT_KEY)
        return f"The pose is kept as shape key '{name}', with value 0", []
