# SPDX-License-Identifier: GPL-3.0-or-later
"""What uses the pose that is shown: Keep Pose and Apply as Rest. Finish is in finish.py."""

import bpy

from ... import ids
from ...errors import SceneError
from ...live import engine
from ...scene import actions, declarations, key_marks, new_rest, pose_key, shape_keys, subject
from ...scene.key_marks import Role
from ...solver.core import result
from ...widgets.background import BackgroundOperator
from ..bridge import control_places, controls, new_handles, targets
from ..bridge.posing import CONTROLS, Posing


class SettledOperator(BackgroundOperator):
    """Mix-in of those that use the pose that is shown: where it is live, it must not lag behind its controls.

    Subclasses define use(obj) in place of run(obj); it finds the settled answer in the result key.
    """

    doing = "Settling"

    def prepare(self, obj):
        return None if _is_settled(obj) else Posing(obj, CONTROLS, is_checked=False, settles=True)

    def finish(self, obj, prepared, outcome):
        if prepared is not None:
            solved, _solution = outcome
            prepared.keep()
            goal = prepared.targets
            composed = result.compose(prepared.bind_input, goal.positions, solved)
            shape_keys.write_result(obj, composed)
        elif not _is_settled(obj):
            raise SceneError(f"A handle of '{obj.name}' was moved meanwhile. Try again")
        return self.use(obj)


def _unposed_problem(obj):
    """Why there is no pose to use, in words, or None."""
    if shape_keys.result(obj) is None:
        return "Nothing is posed yet. Press on the mesh with Grab and drag"
    return shape_keys.why_result_is_hidden(obj)


def _is_settled(obj):
    """A mix of shape keys has no say in the pose."""
    return not obj.meanvalue.live or engine.is_settled(obj)


class MEANVALUE_OT_keep_pose(SettledOperator, bpy.types.Operator):
    """Hand the pose over to a new shape key, whose slider has it from here on. The handles pose on top of it"""

    bl_label = "Keep Pose"
    problems = (_unposed_problem,)

    name: bpy.props.StringProperty(
        name="Name",
        description="Name of the new shape key. If empty: that of the part that is posed",
        maxlen=ids.NAME_LENGTH,
        options={'SKIP_SAVE'},
    )

    def use(self, obj):
        shape, rest = shape_keys.pose_to_use(obj), shape_keys.rest_positions(obj.data)
        key = shape_keys.add_shape(obj, self.name.strip() or new_handles.named_pose(obj, shape - rest), shape)
        key.slider_min = key_marks.mark(Role.KEPT, key.name)
        name = key.name
        obj.active_shape_key_index = obj.data.shape_keys.key_blocks.find(name)  # the panel shows its slider
        handles = targets.followed_handles(obj)
        if any(actions.is_animated(each.control) or len(controls.mover(each).constraints) for each in handles):
            how = "fades" if pose_key.give_way(obj, key) else "has its own keyframes or driver, and does not fade"
            return f"The pose is kept as shape key '{name}', at value 0. The handles' pose {how} as you raise it", []
        engine.look_again(obj)
        with engine.held():
            key.value = 1.0
            shape_keys.write_result(obj, rest)
            control_places.reset(obj, handles)
        obj.update_tag()
        bpy.context.view_layer.update()
        return f"The pose is kept as shape key '{name}'", []


class MEANVALUE_OT_apply_pose(SettledOperator, bpy.types.Operator):
    """Make the pose the new rest shape, to pose on from there. Other shape keys are carried along"""

    bl_label = "Apply as Rest"
    problems = (_unposed_problem,)

    def use(self, obj):
        handles = [handle for handle in obj.meanvalue.handles if handle.control is not None]
        controls.require_places(obj, handles)  # throws before anything is changed
        engine.look_again(obj)
        notes = new_rest.become(obj)
        declarations.clear(obj.meanvalue.bound)
        controls.attach_where_they_are(obj, handles)
        return "The pose is the rest shape now", [*notes, *subject.sharing_notes(obj)]
