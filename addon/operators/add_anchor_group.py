# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts a vertex group on the list of anchors."""

import bpy

from .. import ids
from ..errors import SceneError
from .base import MeshOperator


class MEANVALUE_OT_add_anchor_group(MeshOperator, bpy.types.Operator):
    """Use a vertex group as anchors: its vertices hold and pose the mesh"""

    bl_idname = "meanvalue.add_anchor_group"
    bl_label = "Add Anchor Group"
    needs_object_mode = False

    group: bpy.props.StringProperty(
        name="Vertex Group",
        description="Name of the vertex group. If empty, the active one, or the next that is not on the list",
        maxlen=ids.NAME_LENGTH,
        options={'SKIP_SAVE'},
    )

    def run(self, obj):
        settings = obj.meanvalue
        name = self.group or _next_group_name(obj)
        if name not in obj.vertex_groups:
            raise SceneError(f"'{obj.name}' has no vertex group '{name}'. Choose one that it has")
        if name in settings.anchor_groups:
            raise SceneError(f"Vertex group '{name}' is on the list already. Choose another one")
        settings.anchor_groups.add().name = name
        settings.active_anchor_group = len(settings.anchor_groups) - 1
        return f"'{name}' is an anchor group now", []


def _next_group_name(obj):
    """The active vertex group, or the first one that is not on the list yet."""
    if obj.vertex_groups.active is None:
        raise SceneError(
            f"'{obj.name}' has no vertex groups. Make one in Object Data Properties > Vertex Groups and assign the "
            "anchor vertices to it in Edit Mode"
        )
    for name in (obj.vertex_groups.active.name, *obj.vertex_groups.keys()):
        if name not in obj.meanvalue.anchor_groups:
            return name
    raise SceneError(f"All vertex groups of '{obj.name}' are on the list already. Make another one first")
