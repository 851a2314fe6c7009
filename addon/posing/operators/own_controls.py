# SPDX-License-Identifier: GPL-3.0-or-later
"""Gives a duplicated object controls of its own."""

import bpy

from ... import wording
from ...errors import SceneError
from ...scene import shape_keys, vertex_groups
from ...widgets.base import MeshOperator
from ..bridge import controls


class MEANVALUE_OT_own_controls(MeshOperator, bpy.types.Operator):
    """Make new controls for handles whose control is missing or belongs to another object, as after duplicating"""

    bl_idname = "meanvalue.own_controls"
    bl_label = "Make Own Controls"

    def run(self, obj):
        handles = [
            handle
            for handle in obj.meanvalue.handles
            if handle.follows == 'CONTROL' and handle.name in obj.vertex_groups and controls.problem(obj, handle)
        ]
        if not handles:
            raise SceneError("Every handle has a control of its own already. There is nothing to make")
        rest = shape_keys.rest_positions(obj.data)
        shown = shape_keys.result_positions(obj)
        members = vertex_groups.members(obj, [handle.name for handle in handles])
        for handle in handles:
            own = members[handle.name]
            if len(own) == 0:
                raise SceneError(f"Vertex group '{handle.name}' has no vertices. Assign some, or remove the handle")
        for handle in handles:
            own = members[handle.name]
            controls.add_control(obj, handle, rest[own], (rest if shown is None else shown)[own])
        return f"{wording.counted(len(handles), 'control')} made", []
