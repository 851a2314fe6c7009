# SPDX-License-Identifier: GPL-3.0-or-later
"""Forgets the binding."""

import bpy

from ...solver import session
from ...widgets.base import MeshOperator
from ..bridge import bound_record


class MEANVALUE_OT_unbind(MeshOperator, bpy.types.Operator):
    """Forget the binding. Handles, region and shape keys stay as they are"""

    bl_idname = "meanvalue.unbind"
    bl_label = "Unbind"
    needs_object_mode = False

    @classmethod
    def problem(cls, obj):
        problem = super().problem(obj)
        if problem is None and not obj.meanvalue.bound.is_bound:
            problem = f"'{obj.name}' is not bound"
        return problem

    def run(self, obj):
        record = obj.meanvalue.bound
        session.forget(bound_record.read_fingerprint(record))
        bound_record.clear(record)
        return f"'{obj.name}' is no longer bound", []
