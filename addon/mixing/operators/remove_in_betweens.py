# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes back what Bake Mix made."""

import bpy

from ... import wording
from ...widgets.base import MeshOperator
from ..bridge import in_between_keys, mixed_keys


class MEANVALUE_OT_remove_in_betweens(MeshOperator, bpy.types.Operator):
    """Take away the in-between keys that Bake Mix made. The sliders mix in straight lines then, or live"""

    bl_idname = "meanvalue.remove_in_betweens"
    bl_label = "Remove In-Betweens"

    @classmethod
    def problem(cls, obj):
        problem = super().problem(obj)
        if problem is None and not mixed_keys.in_between_names(obj):
            problem = f"'{obj.name}' has no in-between keys of Bake Mix"
        return problem

    def run(self, obj):
        count = in_between_keys.remove(obj)
        obj.data.update_tag()
        return f"Removed {wording.counted(count, 'in-between key')} of '{obj.name}'", []
