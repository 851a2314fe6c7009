# SPDX-License-Identifier: GPL-3.0-or-later
"""Binds the rest shape, the anchors and the region."""

import bpy

from ..core import result
from ..workers.posing import Posing
from .background import BackgroundOperator


class MEANVALUE_OT_bind(BackgroundOperator, bpy.types.Operator):
    """Encode the rest shape for its handles and region. Do it once, then pose as often as you like"""

    bl_idname = "meanvalue.bind"
    bl_label = "Bind"
    doing = "Binding"

    def prepare(self, obj, reading):
        return Posing.to_bind(obj, reading)

    def finish(self, obj, posing, _outcome):
        posing.record(obj)
        report = posing.binding.deformer.report
        notes = [*result.guarded_notes(report), *result.size_notes(report)]
        message = ". ".join([f"Bound {posing.binding.summary.text()}", *notes])
        return message, list(posing.binding.summary.notes())
