# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes a handle or pin away, with what was made for it."""

import bpy

from ..bridge import controls, selection
from ..errors import SceneError
from .base import MeshOperator


class MEANVALUE_OT_remove_anchor_group(MeshOperator, bpy.types.Operator):
    """Take the active line off the list, with the control and vertex group that were made for it"""

    bl_idname = "meanvalue.remove_anchor_group"
    bl_label = "Remove"
    needs_object_mode = False

    def run(self, obj):
        settings = obj.meanvalue
        index = settings.active_anchor_group
        if index >= len(settings.anchor_groups):
            raise SceneError("No line of the list is selected. Click the anchor group to remove")
        selection.leave_edit_mode(obj)
        line = settings.anchor_groups[index]
        name = line.name
        control = line.control
        if control is not None and bpy.context.view_layer.objects.active == control:
            selection.choose(obj)
        controls.remove_control(line)
        if line.made_group and name in obj.vertex_groups:
            obj.vertex_groups.remove(obj.vertex_groups[name])
        settings.anchor_groups.remove(index)
        obj.update_tag()
        settings.active_anchor_group = max(0, min(index, len(settings.anchor_groups) - 1))
        return f"'{name}' holds nothing any more", []
