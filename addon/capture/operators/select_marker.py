# SPDX-License-Identifier: GPL-3.0-or-later
"""Selects what a line of the list of markers stands for."""

import bpy

from ...errors import SceneError
from ...scene import selection
from ...widgets.base import MeshOperator
from ..bridge import marker_pairs, takes


class MEANVALUE_OT_select_marker(MeshOperator, bpy.types.Operator):
    """Select the marker's control on the mesh or, before it is matched, its Empty in the take"""

    bl_idname = "meanvalue.select_marker"
    bl_label = "Select Marker"
    needs_object_mode = False

    index: bpy.props.IntProperty(
        name="Line", description="Line of the list, from 0; -1 for the active one", default=-1, min=-1,
        options={'SKIP_SAVE'},
    )  # fmt: skip

    def run(self, obj):
        capture = obj.meanvalue.capture
        index = capture.active_pair if self.index < 0 else self.index
        if index >= len(capture.pairs):
            raise SceneError(f"The list has {len(capture.pairs)} markers. Choose one of them")
        pair = capture.pairs[index]
        shown = self._shown(obj, capture, pair)
        capture.active_pair = index
        if shown is None:  # its line stays active, and a point can be picked for it
            return f"'{pair.name}' is chosen", []
        if obj.mode != 'OBJECT':
            selection.leave_edit_mode(obj)
        selection.choose(shown)
        return f"'{shown.name}' is selected", []

    def _shown(self, obj, capture, pair):
        """The object that can be selected for the pair, or None."""
        if marker_pairs.handle_index(obj, pair) is not None:
            shown = pair.control
        else:
            found = takes.markers(capture.take) if takes.is_take(capture.take) else []
            shown = next((empty for empty in found if empty.meanvalue.marker == pair.name), None)
        return shown if shown is not None and shown.name in bpy.context.view_layer.objects else None
