# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes handles and pins of selected vertices or of vertex groups; what is done with those that are there, and which
objects go along."""

import bpy
import numpy as np

from ... import ids, wording
from ...errors import SceneError
from ...live import engine
from ...rooms import ALL
from ...scene import actions, along, rig_space, shape_keys, subject, vertex_groups, worn
from ...scene.core.point_sets import require_finite
from ...widgets.base import MeshOperator
from ..bridge import control_places, controls, members, new_handles, region, scene_input


def _problem(obj):
    """Why nothing is chosen to be held, in words, or None."""
    if obj.mode == 'EDIT':
        return None if obj.data.total_vert_sel else "No vertices are selected. Select the ones to hold"
    if subject.mode_problem(obj):
        return f"{subject.mode_problem(obj)}, or go to Edit Mode"
    return None if len(obj.vertex_groups) else "Select vertices in Edit Mode first, or make a vertex group"


class MEANVALUE_OT_add_handle(MeshOperator, bpy.types.Operator):
    """Make a handle of the selected vertices (Edit Mode) or the active vertex group, with a control to drag"""

    bl_label = "Add Handle"
    switch = "pin"
    begins = True
    needs_object_mode = False
    problems = (_problem,)

    pin: bpy.props.BoolProperty(
        name="Pin",
        description="Pin the selected vertices (Edit Mode) or the active vertex group where they are at rest",
    )
    group: bpy.props.StringProperty(
        name="Vertex Group",
        description="Vertex group to use. If empty: the selected vertices in Edit Mode, else the active group",
    )
    name: bpy.props.StringProperty(name="Name", description="Name of the handle that is made of selected vertices")
    live: bpy.props.BoolProperty(name="Live", description="Turn Live on with the first handle", default=True)
    size: bpy.props.FloatProperty(
        name="Size",
        description="How far the surroundings follow, as a share of the mesh's size. At 0 the region stays as it is",
        min=0.0,
        soft_max=1.0,
        max=3.0,
        subtype='FACTOR',
    )
    # Adjusting the operator runs it again in Object Mode, where the vertices are still selected.
    from_selection: bpy.props.BoolProperty(options={'HIDDEN'})

    def invoke(self, context, _event):
        obj = subject.of(context)
        if obj.mode != 'OBJECT' or self.group or len(obj.vertex_groups) == 0:
            return self.execute(context)
        self.group = vertex_groups.active_name(obj)
        return context.window_manager.invoke_props_dialog(self)

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        obj = subject.of(context)
        if self.from_selection or obj.mode == 'EDIT':
            layout.prop(self, "name")
        else:
            layout.prop_search(self, "group", obj, "vertex_groups")
        if not self.pin:
            layout.prop(self, "size")
            layout.prop(self, "live")

    def run(self, obj):
        controls.remove_deleted(obj)
        is_editing = obj.mode == 'EDIT'
        if is_editing:
            obj.update_from_editmode()
        self.from_selection = self.from_selection or (is_editing and not self.group)
        name, members = self._members(obj)
        if not self.pin:  # these throw before anything is changed
            if self.size > 0.0:
                region.require_own_group(obj)
            require_finite(shape_keys.rest_positions(obj.data)[members], "handle in the rest shape")
            shown = shape_keys.result_positions(obj)
            if shown is not None:
                require_finite(shown[members], f"handle in shape key '{obj.meanvalue.result_key}'")
        subject.leave_edit_mode(obj)
        if not self.pin:
            rig_space.measure(obj)
        kind = ids.PIN_NAME if self.pin else ids.HANDLE_NAME
        handle = new_handles.add_handle(obj, members, group=name, name=self.name, kind=kind)
        count = wording.vertices(len(np.unique(members)))
        if self.pin:
            handle.follows, handle.color = 'REST', new_handles.PIN_COLOR
            message = f"Pin '{handle.name}' holds {count}"
        else:
            is_first = all(other.follows != 'CONTROL' or other == handle for other in obj.meanvalue.handles)
            control = controls.add_control(obj, handle, members)
            if self.size > 0.0:
                handle.size = self.size
                region.write(obj, np.maximum(region.weights(obj), region.around(obj, handle)))
            if self.live and is_first and not obj.meanvalue.live:
                obj.meanvalue.live = True
            subject.choose(control)
            message = f"Handle '{handle.name}' moves {count}: move, turn or scale its control"
        try:
            scene_input.gather(obj)
        except SceneError as problem:  # there is more to do before it can be posed
            return message, [str(problem)]
        return message, []

    def _members(self, obj):
        """(name of the vertex group or "" for a new one, vertex indices). @throws SceneError."""
        if self.from_selection:
            flags = np.zeros(len(obj.data.vertices), bool)
            obj.data.vertices.foreach_get("select", flags)
            members = np.flatnonzero(flags).astype(np.int32)
            if len(members) == 0:
                raise SceneError("No vertices are selected. Select the ones to hold, then press the button again")
            return "", members
        name = self.group or vertex_groups.active_name(obj)
        vertex_groups.require(obj, name, "to be used", "Choose one that it has")
        if name in obj.meanvalue.handles:
            raise SceneError(f"Vertex group '{name}' is on the list already. Choose another group")
        vertices = vertex_groups.members(obj, [name])[name]
        if len(vertices) == 0:
            raise SceneError(f"Vertex group '{name}' has no vertices with a weight above zero. Assign some first")
        return name, vertices


class MEANVALUE_OT_select_handle(MeshOperator, bpy.types.Operator):
    """Select the handle's control; in Edit Mode, and for pins, its vertices"""

    bl_label = "Select Handle"
    needs_object_mode = False
    problems = (controls.none_active,)

    index: bpy.props.IntProperty(
        name="Line", description="Line of the list, from 0; -1 for the active one", default=-1, min=-1
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
        subject.leave_edit_mode(obj)
        subject.choose(obj)
        notes = subject.edit_with_selected(obj, *members.of(obj, [handle]))
        return f"The vertices of '{handle.name}' are selected", notes


class MEANVALUE_OT_remove_handle(MeshOperator, bpy.types.Operator):
    """Remove the active handle or pin, with the control and vertex group that were made for it"""

    bl_label = "Remove Handle"
    needs_object_mode = False
    problems = (controls.none_active,)

    def run(self, obj):
        index = obj.meanvalue.active_handle
        subject.leave_edit_mode(obj)
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
        subject.leave_edit_mode(obj)
        keyed = next(filter(None, (each.keyframe(obj) for each in ALL.shown_keys)), None)
        if keyed is None:
            movers = {controls.mover(handle) for handle in usable}
            for mover in movers:
                insert_keyframes(mover, notes)
            keyed = len(movers), "control"
        return f"Keyframes on {wording.counted(*keyed)} at frame {bpy.context.scene.frame_current}", notes


class MEANVALUE_OT_find_along(MeshOperator, bpy.types.Operator):
    """List the children of the mesh, the meshes on its armature, and selected ones that lie on it"""

    bl_label = "Find What Goes Along"
    needs_object_mode = False

    def run(self, obj):
        worn.remove_deleted(obj)
        found = worn.find(obj)
        obj.update_tag()
        return f"{wording.counted(found, 'object')} found", along.problems(obj)


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
