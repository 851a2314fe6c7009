# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses the mesh once: by its handles, or by a shape key."""

import bpy
import numpy as np

from ... import ids, wording
from ...errors import SceneError
from ...scene import rig_space, shape_keys, subject
from ...solver.core import result
from ...widgets.background import BackgroundOperator
from ..bridge import bound_record, scene_input, targets
from ..bridge.posing import CONTROLS, Posing


class SolvingOperator(BackgroundOperator):
    """Mix-in: finish() for subclasses whose prepare() gives a Posing with targets."""

    doing = "Solving"

    def start_reading(self, obj):
        return scene_input.start_reading(obj)

    def finish(self, obj, posing, outcome):
        solved, summary = outcome
        positions = posing.targets.positions
        warnings = [
            *posing.binding.summary.notes(),
            *summary.notes(),
            *result.pose_warnings(posing.bind_input, positions),
        ]
        if rig_space.note(obj):
            warnings.append(rig_space.note(obj))
        notes = shape_keys.write_result(obj, result.compose(posing.bind_input, positions, solved))
        posing.record(obj)
        bound_record.write_solve(obj.meanvalue.bound, summary)
        shared = subject.sharing_note(obj)
        solved_into = f"Solved into '{obj.meanvalue.result_key}': {summary.text()}"
        return ". ".join([solved_into, *notes, *([shared] if shared else [])]), warnings


class MEANVALUE_OT_solve(SolvingOperator, bpy.types.Operator):
    """Pose the mesh once: handles go where their controls are, the rest follows"""

    bl_idname = "meanvalue.solve"
    bl_label = "Solve"

    @classmethod
    def problem(cls, obj):
        return super().problem(obj) or scene_input.unheld_problem(obj) or targets.problem(obj)

    def prepare(self, obj, reading):
        return Posing(obj, reading, CONTROLS)


class MEANVALUE_OT_solve_from_key(SolvingOperator, bpy.types.Operator):
    """Put handles and pins where a shape key has their vertices, and the rest of the mesh after them, once"""

    bl_idname = "meanvalue.solve_from_key"
    bl_label = "Solve from Shape Key"

    key: bpy.props.StringProperty(
        name="Shape Key",
        description="Shape key in which vertices of handles were moved. If empty, the active one",
        maxlen=ids.NAME_LENGTH,
        options={'SKIP_SAVE'},
    )

    @classmethod
    def problem(cls, obj):
        problem = super().problem(obj) or scene_input.unheld_problem(obj)
        if problem is None and obj.data.shape_keys is None:
            problem = (
                "There are no shape keys. Add one, move the vertices of handles in it, in Edit Mode, and choose it"
            )
        return problem or shape_keys.result_problem(obj)

    def prepare(self, obj, reading):
        self.key = self.key or _active_key(obj)
        return Posing(obj, reading, self.key)

    def finish(self, obj, posing, outcome):
        notes = list(_ignored(obj, posing.bind_input, self.key))
        if obj.meanvalue.live:
            obj.meanvalue.live = False
            notes.append("Live is off: it would have the controls pose the mesh again")
        key = obj.data.shape_keys.key_blocks[self.key]
        message, warnings = super().finish(obj, posing, outcome)
        if self.key != obj.meanvalue.result_key and key.value != 0.0:
            key.value = 0.0
            message += f". Shape key '{self.key}' has the value 0 now, so that it is not added"
        return message, [*warnings, *notes]


def _active_key(obj):
    active, keys = obj.active_shape_key, obj.data.shape_keys
    if active is None or active == keys.reference_key:
        raise SceneError(
            "The active shape key is the rest shape, or there is none, so nothing is posed. Add a shape key, move the "
            "vertices of handles in it, in Edit Mode, and choose it"
        )
    return active.name


def _ignored(obj, bind_input, name):
    """A sentence on vertices that were moved in the shape key and are not solved from there."""
    if name == obj.meanvalue.result_key:
        return
    moved = (shape_keys.positions(obj.data.shape_keys.key_blocks[name]) != bind_input.rest).any(axis=1)
    moved[bind_input.anchors] = False
    count = np.count_nonzero(moved)
    if count:
        yield f"{wording.counted(count, 'vertex', 'vertices')} moved in '{name}' belong to no handle and are ignored"
