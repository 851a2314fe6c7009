# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps the pose as a shape key."""

import bpy

from ... import ids
from ...errors import SceneError
from ...scene import shape_keys
from .settled import SettledOperator, unposed_problem


class MEANVALUE_OT_keep_pose(SettledOperator, bpy.types.Operator):
    """Store the pose as a new shape key, at value 0, and go on posing"""

    bl_idname = "meanvalue.keep_pose"
    bl_label = "Keep Pose"

    name: bpy.props.StringProperty(
        name="Name", description="Name of the new shape key", default=ids.KEPT_KEY, maxlen=ids.NAME_LENGTH
    )

    @classmethod
    def problem(cls, obj):
        return super().problem(obj) or unposed_problem(obj)

    def use(self, obj):
        shape = shape_keys.result_positions(obj)
        if shape is None:
            raise SceneError(
                f"There is no result to keep: the shape key '{obj.meanvalue.result_key}' is missing. Move a handle "
                "with Live on, or press Solve"
            )
        name = shape_keys.add_shape(obj, self.name.strip() or ids.KEPT_KEY, shape).name
        obj.active_shape_key_index = obj.data.shape_keys.key_blocks.find(name)  # the panel shows its slider
        return f"The pose is kept as shape key '{name}'", []
