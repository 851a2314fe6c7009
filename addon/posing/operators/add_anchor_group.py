# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts a vertex group on the list of handles."""

import bpy

from ... import ids
from ...errors import SceneError
from ...scene import selection, vertex_groups
from ...widgets.base import MeshOperator
from ..bridge import new_handles


class MEANVALUE_OT_add_anchor_group(MeshOperator, bpy.types.Operator):
    """Put a vertex group on the list, as a handle with a control of its own"""

    bl_idname = "meanvalue.add_anchor_group"
    bl_label = "Add Vertex Group"
    needs_object_mode = False

    group: bpy.props.StringProperty(
        name="Vertex Group",
        description="Name of the vertex group. If empty, the active one, or the next that is not on the list",
        maxlen=ids.NAME_LENGTH,
        options={'SKIP_SAVE'},
    )
    follows: bpy.props.EnumProperty(
        name="Follows",
        description="What its vertices follow",
        items=(
            ('CONTROL', "Control", "An Empty that is made for them: move, turn or scale it", 'EMPTY_AXIS', 0),
            ('SHAPE', "Shape Key", "The active shape key: move the vertices in Edit Mode", 'SHAPEKEY_DATA', 1),
            ('REST', "Nothing", "A pin: the vertices stay where the rest shape has them", 'PINNED', 2),
        ),
        default='CONTROL',
        options={'SKIP_SAVE'},
    )

    def run(self, obj):
        name = self.group or _next_group_name(obj)
        if name not in obj.vertex_groups:
            raise SceneError(f"'{obj.name}' has no vertex group '{name}'. Choose one that it has")
        if name in obj.meanvalue.handles:
            raise SceneError(f"Vertex group '{name}' is on the list already. Choose another one")
        if self.follows == 'CONTROL':
            if obj.mode == 'EDIT':
                obj.update_from_editmode()
            members = vertex_groups.members(obj, [name])[name]
            if len(members) == 0:
                raise SceneError(f"Vertex group '{name}' has no vertices with a weight above zero. Assign some first")
            selection.leave_edit_mode(obj)
            new_handles.make_handle(obj, new_handles.add_handle(obj, members, group=name), members)
            return f"'{name}' is a handle now: move, turn or scale its control", []
        selection.leave_edit_mode(obj)
        handle = new_handles.add_handle(obj, (), group=name)
        if self.follows == 'REST':
            new_handles.make_pin(handle)
            return f"'{name}' is a pin now", []
        handle.follows = 'SHAPE'
        return f"'{name}' follows the active shape key now", []


def _next_group_name(obj):
    """The active vertex group, or the first one that is not on the list yet."""
    if obj.vertex_groups.active is None:
        raise SceneError(
            f"'{obj.name}' has no vertex groups. Make one in Object Data Properties > Vertex Groups and assign the "
            "vertices of the handle to it in Edit Mode"
        )
    for name in (obj.vertex_groups.active.name, *obj.vertex_groups.keys()):
        if name not in obj.meanvalue.handles:
            return name
    raise SceneError(f"All vertex groups of '{obj.name}' are on the list already. Make another one first")
