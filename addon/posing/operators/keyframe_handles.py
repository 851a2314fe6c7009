# SPDX-License-Identifier: GPL-3.0-or-later
"""Inserts keyframes on the controls."""

import bpy

from ... import wording
from ...errors import SceneError
from ...scene import selection
from ...widgets.base import MeshOperator
from ..bridge import controls

#: What Blender calls the channels of rotation in each mode of rotation; Euler angles in all others.
ROTATIONS = {'QUATERNION': "rotation_quaternion", 'AXIS_ANGLE': "rotation_axis_angle"}


class MEANVALUE_OT_keyframe_handles(MeshOperator, bpy.types.Operator):
    """Insert keyframes on place, turn and size of the controls, at the current frame"""

    bl_idname = "meanvalue.keyframe_handles"
    bl_label = "Keyframe Handles"
    needs_object_mode = False

    selected: bpy.props.BoolProperty(
        name="Selected Only",
        description="Only the controls that are selected, and of bones those that are selected in Pose Mode",
        default=False,
        options={'SKIP_SAVE'},
    )

    @classmethod
    def problem(cls, obj):
        return super().problem(obj) or controls.none_to_move(obj)

    def run(self, obj):
        handles = [handle for handle in obj.meanvalue.handles if handle.follows == 'CONTROL']
        usable = [handle for handle in handles if controls.problem(obj, handle) is None]
        notes = [controls.problem(obj, handle) for handle in handles if handle not in usable]
        chosen = [handle for handle in usable if not self.selected or controls.is_selected(handle)]
        if usable and not chosen:
            raise SceneError("No control is selected. Select some, or turn Selected Only off")
        if not chosen:
            raise SceneError(notes[0])
        selection.leave_edit_mode(obj)
        movers = {controls.mover(handle) for handle in chosen}
        for mover in movers:
            insert(mover, notes)
        frame = bpy.context.scene.frame_current
        return f"Keyframes on {wording.counted(len(movers), 'control')} at frame {frame}", notes


def insert(mover, notes):
    """Keys an object or a pose bone at the current frame; what is in the way goes to `notes`."""
    is_bone = isinstance(mover, bpy.types.PoseBone)
    group = mover.name if is_bone else "Object Transforms"
    for channel in ("location", ROTATIONS.get(mover.rotation_mode, "rotation_euler"), "scale"):
        try:
            mover.keyframe_insert(channel, group=group)
        except (RuntimeError, TypeError) as error:  # a linked or locked action
            notes.append(f"'{mover.name}' takes no keyframes on {channel}: {error}")
            return
