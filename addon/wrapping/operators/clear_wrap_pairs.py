# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes picked pairs back."""

import bpy

from ... import wording
from ...errors import SceneError
from ...scene import subject
from ...widgets.base import MeshOperator


class MEANVALUE_OT_clear_wrap_pairs(MeshOperator, bpy.types.Operator):
    """Forget the pairs that Wrap goes by"""

    bl_idname = "meanvalue.clear_wrap_pairs"
    bl_label = "Clear Pairs"
    needs_object_mode = False

    only_last: bpy.props.BoolProperty(name="Only Last", description="Forget the last pair alone", options={'SKIP_SAVE'})

    @classmethod
    def problem(cls, obj):
        return subject.object_problem(obj) or (None if obj.meanvalue.wrap.pairs else "No pairs are picked")

    def run(self, obj):
        pairs = obj.meanvalue.wrap.pairs
        if not pairs:
            raise SceneError("No pairs are picked")
        if self.only_last:
            pairs.remove(len(pairs) - 1)
        else:
            pairs.clear()
        return f"'{obj.name}' has {wording.counted(len(pairs), 'pair')} left", []
