# SPDX-License-Identifier: GPL-3.0-or-later
"""The artist shows where on the mesh a marker is, or takes it off the mesh."""

import bpy

from ...errors import SceneError
from ...scene import selection
from ...widgets import picking
from ..bridge import marker_handles, marker_matching, marker_pairs, match_input


class MEANVALUE_OT_pick_marker_point(picking.PickingOperator, bpy.types.Operator):
    """Click the point of the mesh where the active marker belongs. Match Markers keeps it"""

    bl_label = "Pick Marker Point"
    problems = (marker_pairs.list_problem,)
    switch = "remove"

    marker: bpy.props.StringProperty(
        name="Marker",
        description="Name of the marker. If empty: that of the active control or Empty, else the active line's",
        options={'SKIP_SAVE'},
    )
    vertex: bpy.props.IntProperty(
        name="Vertex", description="Vertex to choose; -1 to click at it", default=-1, min=-1, options={'SKIP_SAVE'}
    )

    remove: bpy.props.BoolProperty(
        name="Remove Marker",
        description="Delete the marker's handle and control, and leave it out until its box is ticked again",
        options={'SKIP_SAVE'},
    )

    def is_given(self):
        return self.remove or self.vertex >= 0

    def prompt(self, obj):
        self.marker = self._pair(obj).name  # what is active may change meanwhile
        return f"Click the point of '{self.marker}' on '{obj.name}'    Esc: Cancel"

    def click(self, obj, view):
        self.vertex = picking.vertex_clicked(obj, view)
        return True

    def run(self, obj):
        pair = self._pair(obj)
        return _removed(obj, pair) if self.remove else self._picked(obj, pair)

    def _picked(self, obj, pair):
        picking.require_vertex(obj, self.vertex)
        other = next(
            (each for each in obj.meanvalue.capture.pairs if each.vertex == self.vertex and each != pair), None
        )
        if other is not None and (other.is_picked or other.control is not None):
            raise SceneError(f"That vertex carries marker '{other.name}' already. Click another one")
        name = pair.name
        if marker_pairs.handle_index(obj, pair) is not None:
            pair.is_used = True
            matched = marker_matching.find(match_input.read_again(obj, name, self.vertex))
            if obj.meanvalue.capture.mode == 'RETARGET':  # by the lengths of the character: all move
                marker_handles.update_handles(obj, matched)
            elif name in matched.names:
                marker_handles.update_handle(obj, matched, matched.names.index(name))
        pair = obj.meanvalue.capture.pairs[name]
        pair.vertex, pair.is_picked, pair.is_used = self.vertex, True, True
        if pair.control is None:
            return f"'{name}' belongs to vertex {self.vertex}. Match Markers goes by it", []
        return f"'{name}' carries vertex {self.vertex} now, {pair.distance:.3g} from the marker", []

    def _pair(self, obj):
        """@throws SceneError if there is no such marker."""
        capture = obj.meanvalue.capture
        if self.marker and self.marker not in capture.pairs:
            raise SceneError(f"'{self.marker}' is no marker of the take. Choose one of the list in Motion Capture")
        if self.marker:
            return capture.pairs[self.marker]
        pair = marker_pairs.meant(obj, bpy.context.object)
        if pair is None:
            raise SceneError("No marker is chosen. Click one in the list of Motion Capture")
        return pair


def _removed(obj, pair):
    if bpy.context.object == pair.control:
        selection.choose(obj)
    marker_handles.drop(obj, pair)
    pair.is_used = pair.is_picked = False
    pair.vertex, pair.distance = -1, -1.0
    return f"'{pair.name}' moves the mesh no more. Tick it and press Match Markers to have it back", []
