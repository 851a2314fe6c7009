# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes a vertex group off the list of anchors."""

import bpy

from ..errors import SceneError
from .base import MeshOperator


class MEANVALUE_OT_remove_anchor_group(MeshOperator, bpy.types.Operator):
    """Take the selected line off the list of anchors. The vertex group itself stays"""

    bl_idname = "meanvalue.remove_anchor_group"
    bl_label = "Remove Anchor Group"
    needs_object_mode = False

    def run(self, obj):
        settings = obj.meanvalue
        index = settings.active_anchor_group
        if index >= len(settings.anchor_groups):
            raise SceneError("No line of the list is selected. Click the anchor group to remove")
        name = settings.anchor_groups[index].name
        settings.anchor_groups.remove(index)
        settings.active_anchor_group = max(0, min(index, len(settings.anchor_groups) - 1))
        return f"'{name}' is no longer an anchor group", []
