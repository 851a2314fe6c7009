# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the pose the rest shape."""

import bpy

from ..bridge import bound_record, controls, scene_input, shape_keys
from ..live import engine
from .base import MeshOperator


class MEANVALUE_OT_apply_pose(MeshOperator, bpy.types.Operator):
    """Make the pose the new rest shape, to pose on from there. Other shape keys are carried along"""

    bl_idname = "meanvalue.apply_pose"
    bl_label = "Apply as Rest"

    def run(self, obj):
        engine.settle(obj)
        shape_keys.apply_as_rest(obj)
        bound_record.clear(obj.meanvalue.bound)
        for line in obj.meanvalue.anchor_groups:
            if line.follows == 'CONTROL':
                controls.take_hold(obj, line)
        shared = scene_input.sharing_note(obj)
        return "The pose is the rest shape now. The mesh is bound again when it is posed", [shared] if shared else []
