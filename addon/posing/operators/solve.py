# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses the mesh by its anchors and writes the result as a shape key."""

import bpy

from ...errors import SceneError
from ...scene import rig_space, shape_keys, subject
from ...solver.core import result
from ...widgets.background import BackgroundOperator
from ..bridge import bound_record, scene_input
from ..bridge.posing import Posing


class MEANVALUE_OT_solve(BackgroundOperator, bpy.types.Operator):
    """Pose the mesh: handles go where their controls or the active shape key have them, the rest follows"""

    bl_idname = "meanvalue.solve"
    bl_label = "Solve"
    doing = "Solving"

    def start_reading(self, obj):
        _require_bound(obj)
        return scene_input.start_reading(obj)

    def prepare(self, obj, reading):
        _require_bound(obj)
        return Posing.to_solve(obj, reading)

    def finish(self, obj, posing, outcome):
        solved, summary = outcome
        targets = posing.targets
        result_is_pose = targets.pose_key == obj.meanvalue.result_key
        warnings = [
            *posing.binding.summary.notes(),
            *summary.notes(),
            *result.pose_warnings(posing.bind_input, targets.positions, None if result_is_pose else targets.pose),
        ]
        if rig_space.note(obj):
            warnings.append(rig_space.note(obj))
        composed = result.compose(posing.bind_input, targets.positions, solved)
        notes = shape_keys.write_result(obj, composed, targets.pose_key)
        posing.keep()
        if posing.changes:
            posing.record(obj)
            notes.insert(0, f"Bound again, because {posing.changes}")
        bound_record.write_solve(obj.meanvalue.bound, summary)
        return _message(obj, summary, notes), warnings


def _require_bound(obj):
    if not obj.meanvalue.bound.is_bound:
        raise SceneError(f"'{obj.name}' is not bound yet. Press Bind first")


def _message(obj, summary, notes):
    shared = subject.sharing_note(obj)
    solved = f"Solved into '{obj.meanvalue.result_key}': {summary.text()}"
    return ". ".join([solved, *notes, *([shared] if shared else [])])
