# SPDX-License-Identifier: GPL-3.0-or-later
"""What is done with handles that are there: select, remove, reset, keyframe."""

import bpy

from ... import wording
from ...errors import SceneError
from ...live import engine
from ...rooms import ALL
from ...scene import actions, selection, vertex_groups
from ...widgets.base import MeshOperator
from ..bridge import control_places, controls, members, region


class MEANVALUE_OT_select_handle(MeshOperator, bpy.types.Operator):
    """Select the handle's control; in Edit Mode, and for pins, its vertices"""

    bl_label = "Select Handle"
    needs_object_mode = False
    problems = (controls.none_active,)

    index: bpy.props.IntProperty(
        name="Line",
        description="Line of the list, from 0; -1 for the active one",
        default=-1,
        min=-1,
        options={'SKIP_SAVE'},
    )

    def run(self, obj):
        settings = obj.meanvalue
        index = settings.active_handle if self.index < 0 else self.index
        if index >= len(settings.handles):
            raise SceneError(f"There are {len(settings.handles)} handles and pins. Choose one of them")
        settings.active_handle = index
        handle = settings.handles[index]
        if handle.follows == 'CONTROL' and obj.mode != 'EDIT':
            controls.select(handle)
            return f"The control of '{handle.name}' is selected", []
        members.require_listed(obj, handle)
        vertex_groups.make_active(obj, handle.name)
        selection.leave_edit_mode(obj)
        selection.choose(obj)
        notes = selection.edit_with_selected(obj, *members.of(obj, [handle]))
        return f"The vertices of '{handle.name}' are selected", notes


class MEANVALUE_OT_remove_handle(MeshOperator, bpy.types.Operator):
    """Remove the active handle or pin, with the control and vertex group that were made for it"""

    bl_label = "Remove Handle"
    needs_object_mode = False
    problems = (controls.none_active,)

    def run(self, obj):
        index = obj.meanvalue.active_handle
        selection.leave_edit_mode(obj)
        name = obj.meanvalue.handles[index].name
        region.let_go(obj, obj.meanvalue.handles[index])
        controls.remove_handle(obj, index)
        return f"'{name}' holds nothing any more", []


class MEANVALUE_OT_reset_handles(MeshOperator, bpy.types.Operator):
    """Put every control back to where its handle is in the rest shape. Controls moved by keyframes stay animated"""

    bl_label = "Reset Handles"
    problems = (controls.none_to_move,)

    def run(self, obj):
        controls.remove_deleted(obj)
        usable, notes = _usable(obj)
        with engine.held():  # the mesh follows once, when all are where they belong
            held = [handle.name for handle in control_places.reset(obj, usable)]
        obj.update_tag()
        bpy.context.view_layer.update()
        if held:
            notes.append(f"{wording.quoted(held)} not at rest: a posed parent or a constraint moves it. Reset that too")
        return f"{wording.counted(len(usable), 'handle')} reset", notes


class MEANVALUE_OT_keyframe_handles(MeshOperator, bpy.types.Operator):
    """Insert keyframes on place, turn and size of the controls, or on the keys they drive, at the current frame"""

    bl_label = "Keyframe Handles"
    needs_object_mode = False
    problems = (controls.none_to_move,)

    def run(self, obj):
        usable, notes = _usable(obj)
        if not usable:
            raise SceneError(notes[0])
        selection.leave_edit_mode(obj)
        keyed = next(filter(None, (each.keyframe(obj) for each in ALL.shown_keys)), None)
        if keyed is None:
            movers = {controls.mover(handle) for handle in usable}
            for mover in movers:
                insert_keyframes(mover, notes)
            keyed = len(movers), "control"
        return f"Keyframes on {wording.counted(*keyed)} at frame {bpy.context.scene.frame_current}", notes


def insert_keyframes(mover, notes):
    """Keys an object or a pose bone at the current frame; what is in the way goes to `notes`."""
    is_bone = isinstance(mover, bpy.types.PoseBone)
    group = mover.name if is_bone else "Object Transforms"
    for channel in ("location", actions.rotation_path(mover), "scale"):
        try:
            actions.insert_key(mover, channel, group=group)
        except SceneError as error:
            notes.append(str(error))
            return


def _usable(obj):
    """(handles whose controls can be followed, [why not] of the others)."""
    handles = [handle for handle in obj.meanvalue.handles if handle.follows == 'CONTROL']
    problems = [controls.problem(obj, handle) for handle in handles]
    usable = [handle for handle, problem in zip(handles, problems, strict=True) if problem is None]
    return usable, [problem for problem in problems if problem is not None]
