# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses the mesh by its handles and writes the result as a shape key."""

import bpy

from ...errors import SceneError
from ..bridge import scene_input
from ..bridge.posing import Posing
from .solving import SolvingOperator


class MEANVALUE_OT_solve(SolvingOperator, bpy.types.Operator):
    """Pose the mesh once: handles go where their controls are, the rest follows"""

    bl_idname = "meanvalue.solve"
    bl_label = "Solve"

    def start_reading(self, obj):
        _require_bound(obj)
        return scene_input.start_reading(obj)

    def prepare(self, obj, reading):
        _require_bound(obj)
        return Posing.to_solve(obj, reading)


def _require_bound(obj):
    if not obj.meanvalue.bound.is_bound:
        raise SceneError(f"'{obj.name}' is not bound yet. Press Bind first")
