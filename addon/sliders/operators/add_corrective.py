# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts what the driven shape keys do not reach into one more."""

import bpy

from ...errors import SceneError
from ...live import engine
from ...posing.bridge import scene_input, targets
from ...widgets.background import BackgroundOperator
from ..bridge import driven_keys, key_shapes
from ..bridge.corrective import Corrective


def _undriven_problem(obj):
    return None if driven_keys.is_on(obj) else "Handles drive no shape keys. Choose Shape Keys in Drive"


class MEANVALUE_OT_add_corrective(BackgroundOperator, bpy.types.Operator):
    """Put what the sliders do not reach into one more shape key, Corrective, with which all handles are met"""

    bl_label = "Add Corrective"
    doing = "Finding the corrective of"
    problems = (_undriven_problem, key_shapes.problem, scene_input.unheld_problem, targets.problem)

    def prepare(self, obj):
        if obj.meanvalue.live and not engine.is_settled(obj):
            raise SceneError("The sliders still follow the handles. Try again when they are there")
        return Corrective(obj)

    def finish(self, obj, prepared, outcome):
        return f"Shape key '{prepared.write(obj, outcome)}' of '{obj.name}' adds what sliders do not reach", []
