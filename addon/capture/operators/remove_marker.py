# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes a marker off the mesh."""

import bpy

from ...errors import SceneError
from ...scene import selection
from ...widgets.base import MeshOperator
from ..bridge import marker_handles, marker_pairs


class MEANVALUE_OT_remove_marker(MeshOperator, bpy.types.Operator):
    bl_idname = "meanvalue.remove_marker"
    bl_label = "Remove Marker"
    bl_description = (
        "Let the mesh go from the active marker: its handle and control are deleted, the imported Empty stays. "
        "Match Markers leaves it out until its box is ticked again"
    )

    index: bpy.props.IntProperty(
        name="Line", description="Line of the list, from 0; -1 for the active one", default=-1, min=-1,
        options={'SKIP_SAVE'},
    )  # fmt: skip

    def run(self, obj):
        pairs = obj.meanvalue.capture.pairs
        index = marker_pairs.index_meant(obj, bpy.context.object) if self.index < 0 else self.index
        if index is None or index >= len(pairs):
            raise SceneError("No marker is chosen. Click one in the list of Motion Capture")
        pair = pairs[index]
        if bpy.context.object == pair.control:
            selection.choose(obj)
        marker_handles.drop(obj, pair)
        pair.is_used = False
        pair.is_picked = False
        pair.vertex, pair.distance = -1, -1.0
        return f"'{pair.name}' moves the mesh no more. Tick it and press Match Markers to have it back", []
