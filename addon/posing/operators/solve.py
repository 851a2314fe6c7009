# SPDX-License-Identifier: GPL-3.0-or-later
"""Binds a mesh; poses it once, by its handles or by a shape key."""

import bpy
import numpy as np

from ... import wording
from ...errors import SceneError
from ...scene import along, shape_keys, subject
from ...solver.core import result
from ...widgets.background import BackgroundOperator
from ...widgets.base import MeshOperator
from ..bridge import controls, members, new_handles, scene_input, targets
from ..bridge.posing import CONTROLS, Posing, release


class MEANVALUE_OT_bind(BackgroundOperator, bpy.types.Operator):
    """Take the mesh as it was edited for the rest shape, and give handles without a control one of their own"""

    bl_label = "Update"
    doing = "Updating"
    problems = (scene_input.unheld_problem,)

    def prepare(self, obj):
        return Posing(obj, is_checked=False)

    def finish(self, obj, posing, _outcome):
        handles = targets.followed_handles(obj)
        controls.require_places(obj, handles)  # throws before anything is changed
        bound = obj.meanvalue.bound
        if bound.is_bound and bound.rest_shape != posing.bind_input.fingerprint.rest_shape:
            # Edited, subdivided, scaled: controls, not moved for that, move their handles from where these are now.
            controls.attach_where_they_are(obj, handles, [controls.shown_move(obj, handle) for handle in handles])
        controls.remove_deleted(obj)
        # Of those that are missing or belong to another object, as after duplicating. Its own that are in no
        # collection, as when it was appended alone, are put back.
        lone = [handle for handle in targets.enabled_handles(obj) if handle.follows == 'CONTROL']
        lone = [handle for handle in lone if controls.why_it_is_missing(obj, handle)]
        for handle, vertices in zip(lone, members.of(obj, lone), strict=True):
            if handle.made_control and controls.owner_of(handle.control) == obj:
                controls.put_beside(obj, handle.control)
            else:
                new_handles.make_handle(obj, handle, vertices, handle.color)
        posing.record(obj)
        message = f"Updated. {wording.counted(len(lone), 'control')} made" if lone else "Updated"
        return message, posing.binding.notes


class MEANVALUE_OT_unbind(MeshOperator, bpy.types.Operator):  # in no menu; scripts rely on its name
    """Forget the binding and free its memory, for scripts. Handles, region and shape keys stay as they are"""

    bl_label = "Unbind"
    needs_object_mode = False
    problems = (lambda obj: None if obj.meanvalue.bound.is_bound else f"'{obj.name}' is not bound",)

    def run(self, obj):
        release(obj.meanvalue.bound)
        return f"'{obj.name}' is no longer bound", []


class SolvingOperator(BackgroundOperator):
    """Mix-in: finish() for subclasses whose prepare() gives a Posing with targets."""

    doing = "Solving"

    def finish(self, obj, posing, outcome):
        solved, solution = outcome
        positions = posing.targets.positions
        warnings = [
            *posing.binding.notes,
            *result.pose_warnings(posing.bind_input, positions),
            *targets.held_back_notes(posing.targets.held_back),
        ]
        if not solution.converged:
            why = f"It stopped before it had converged ({solution.stop_reason})"
            warnings.append(f"{why}. Look at the shape, or move handles less")
        notes = along.write_result(obj, result.compose(posing.bind_input, positions, solved))
        posing.record(obj)
        return ". ".join([f"Solved into '{obj.meanvalue.result_key}'", *notes, *subject.sharing_notes(obj)]), warnings


class MEANVALUE_OT_solve(SolvingOperator, bpy.types.Operator):
    """Pose the mesh once: handles go where their controls are, the rest follows"""

    bl_label = "Solve"
    problems = (scene_input.unheld_problem, targets.problem)

    def prepare(self, obj):
        return Posing(obj, CONTROLS)


def _without_keys(obj):
    why = "There are no shape keys. Add one, and move the vertices of handles in it, in Edit Mode"
    return None if obj.data.shape_keys else why


class MEANVALUE_OT_solve_from_key(SolvingOperator, bpy.types.Operator):
    """Put handles and pins where a shape key has their vertices, and the rest of the mesh after them, once"""

    bl_label = "Solve from Shape Key"
    problems = (scene_input.unheld_problem, _without_keys, shape_keys.result_problem)

    key: bpy.props.StringProperty(
        name="Shape Key", description="Shape key in which vertices of handles were moved. If empty, the active one"
    )

    def prepare(self, obj):
        active = obj.active_shape_key
        if not self.key and active in {None, obj.data.shape_keys.reference_key}:
            raise SceneError("The active shape key is the rest shape. Choose one in which vertices were moved")
        self.key = self.key or active.name
        return Posing(obj, self.key)

    def finish(self, obj, posing, outcome):
        notes, key = [], obj.data.shape_keys.key_blocks[self.key]
        is_result = self.key == obj.meanvalue.result_key
        moved = (shape_keys.positions(key) != posing.bind_input.rest).any(axis=1)
        moved[posing.bind_input.anchors] = False
        if moved.any() and not is_result:
            count = wording.counted(np.count_nonzero(moved), "vertex", "vertices")
            notes.append(f"{count} moved in '{self.key}' belong to no handle and are ignored")
        if obj.meanvalue.live:
            obj.meanvalue.live = False
            notes.append("Live is off: it would have the controls pose the mesh again")
        message, warnings = super().finish(obj, posing, outcome)
        if not is_result and key.value != 0.0:
            key.value = 0.0
            message += f". Shape key '{self.key}' has the value 0 now, so that it is not added"
        return message, [*warnings, *notes]
