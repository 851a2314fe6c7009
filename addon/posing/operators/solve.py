# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses the mesh once by its handles."""

import bpy

from ..bridge import scene_input, targets
from ..bridge.posing import CONTROLS, Posing
from .solving import SolvingOperator


class MEANVALUE_OT_solve(SolvingOperator, bpy.types.Operator):
    """Pose the mesh once: handles go where their controls are, the rest follows"""

    bl_idname = "meanvalue.solve"
    bl_label = "Solve"

    @classmethod
    def problem(cls, obj):
        return super().problem(obj) or scene_input.unheld_problem(obj) or targets.problem(obj)

    def start_reading(self, obj):
        return scene_input.start_reading(obj)

    def prepare(self, obj, reading):
        return Posing(obj, reading, CONTROLS)
