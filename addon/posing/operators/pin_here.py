# SPDX-License-Identifier: GPL-3.0-or-later
"""Pins the mesh where it is clicked, or lets go of the pin there."""

import bpy

from ... import ids, wording
from ...errors import MeanValueError, SceneError
from ...scene import selection, subject, vertex_groups
from ..bridge import controls, new_handles, region
from ..bridge.grip import handle_at, near_vertices
from .pressing import ToolOperator, in_front, require_vertex, size_property


class MEANVALUE_OT_pin_here(ToolOperator, bpy.types.Operator):
    """Pin the mesh under the mouse where it is now; a pin that is there is let go"""

    bl_idname = "meanvalue.pin_here"
    bl_label = "Pin Here"
    bl_options = {'REGISTER', 'UNDO'}

    size: size_property("As of Grab: the pin holds as much as a new handle of that size")

    def invoke(self, context, event):
        try:
            obj, pressed, covered = self.find_pressed(context, event)
        except SceneError as error:
            return self.warn(error)
        if covered:
            return self.warn(SceneError(in_front(obj, covered)))
        self.object_name, self.vertex = obj.name, pressed.vertex
        if pressed.handle:
            members = vertex_groups.members(obj, [pressed.handle])[pressed.handle]
            self.vertex = int(members[0]) if len(members) else -1
        return self.execute(context)

    def execute(self, context):
        try:
            obj = self.find_object(context)
            require_vertex(obj, self.vertex)
            message, notes = self._toggle(obj)
        except MeanValueError as error:
            return self.refuse(error)
        if obj != subject.of(context):
            selection.choose(obj)
        return self.tell(message, notes)

    def _toggle(self, obj):
        index = handle_at(obj, self.vertex)
        if index is not None:
            return _let_go(obj, index)
        members = near_vertices(obj, self.vertex, region.HANDLE_SHARE * region.radius(obj, self.size))
        handle = new_handles.add_handle(obj, members, new_name=ids.PIN_GROUP)
        if new_handles.is_posed(obj, members):
            new_handles.make_handle(obj, handle, members, new_handles.PIN_COLOR)
            handle.is_pin = True
        else:
            new_handles.make_pin(handle)
        obj.update_tag()
        notes = []
        if obj.meanvalue.roi_group and not region.current_mask(obj)[self.vertex]:
            notes.append("Nothing moves here anyway: it is outside the region")
        held = f"Pin '{handle.name}' holds {wording.vertices(len(members))}; Shift-click it again to let go"
        return held, notes


def _let_go(obj, index):
    handle = obj.meanvalue.handles[index]
    if not _is_pin(handle):
        raise SceneError(
            f"'{handle.name}' is a handle: drag it, or leave it where it is, since it holds the mesh like a pin. To "
            "remove it, click it in the list and press -"
        )
    name = handle.name
    controls.remove_handle(obj, index)
    return f"Pin '{name}' is let go", []


def _is_pin(handle):
    return handle.follows == 'REST' or handle.is_pin
