# SPDX-License-Identifier: GPL-3.0-or-later
"""Selects a handle's control, or its vertices."""

import bpy

from ...errors import SceneError
from ...scene import selection, vertex_groups
from ...widgets.base import MeshOperator
from ..bridge import controls


class MEANVALUE_OT_select_handle(MeshOperator, bpy.types.Operator):
    """Select the handle's control; in Edit Mode, and for pins, its vertices"""

    bl_idname = "meanvalue.select_handle"
    bl_label = "Select Handle"
    needs_object_mode = False

    index: bpy.props.IntProperty(
        name="Line",
        description="Line of the list, from 0; -1 for the active one",
        default=-1,
        min=-1,
        options={'SKIP_SAVE'},
    )

    @classmethod
    def problem(cls, obj):
        problem = super().problem(obj)
        if problem is None and not obj.meanvalue.handles:
            problem = "There are no handles yet. Press on the mesh with Grab, or press Add Handle"
        return problem

    def run(self, obj):
        settings = obj.meanvalue
        index = settings.active_handle if self.index < 0 else self.index
        if index >= len(settings.handles):
            raise SceneError(f"There are {len(settings.handles)} handles and pins. Choose one of them")
        settings.active_handle = index
        handle = settings.handles[index]
        if handle.follows == 'CONTROL' and obj.mode != 'EDIT':
            problem = controls.problem(obj, handle)
            if problem:
                raise SceneError(problem)
            controls.select(handle)
            return f"The control of '{handle.name}' is selected", []
        return self._select_vertices(obj, handle.name)

    def _select_vertices(self, obj, name):
        vertex_groups.require_listed(obj, name)
        obj.vertex_groups.active_index = obj.vertex_groups[name].index
        selection.choose(obj)
        if obj.mode != 'EDIT':
            bpy.ops.object.mode_set(mode='EDIT')
        bpy.ops.mesh.select_all(action='DESELECT')
        bpy.ops.object.vertex_group_select()
        return f"The vertices of '{name}' are selected", []
