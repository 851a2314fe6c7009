# SPDX-License-Identifier: GPL-3.0-or-later
"""Has the mesh carried by the markers of a take; the artist shows where on it a marker is, or takes it off."""

import bpy

from ... import wording
from ...errors import ChangedMeanwhileError, SceneError
from ...posing.bridge import members, scene_input, targets
from ...scene import shape_keys, subject
from ...widgets import picking
from ...widgets.background import BackgroundOperator
from ..bridge import marker_handles, marker_matching, marker_pairs, match_input


class MEANVALUE_OT_match_markers(BackgroundOperator, bpy.types.Operator):
    """Lay the markers of the reference frame on the mesh, give each its point, and have soft handles follow them"""

    bl_label = "Match Markers"
    doing = "Matching markers to"
    problems = (match_input.problem,)

    def _all_steps(self):
        """In place of a job: numpy's work goes on between looks at the interface, so that Esc is heard."""
        given = match_input.read(self.object())
        facts = match_input.facts(self.object(), given)
        matched = yield from marker_matching.steps(given)
        obj = self.object()
        if match_input.facts(obj, match_input.read(obj)) != facts:
            raise ChangedMeanwhileError(obj.name)
        return self._write(obj, matched)

    def _write(self, obj, matched):
        marker_handles.update_handles(obj, matched)
        notes = list(matched.notes)
        own = {pair.control for pair in marker_pairs.matched(obj)}
        handles, held = [handle for handle in targets.enabled_handles(obj) if handle.control not in own], {}
        for handle, vertices in zip(handles, members.of(obj, handles), strict=True):
            held.update(dict.fromkeys(vertices.tolist(), handle.name))
        places = zip(matched.names, matched.vertices.tolist(), strict=True)
        both = {name: held[vertex] for name, vertex in places if vertex in held}
        if both:
            notes.append(
                f"{wording.quoted(both)} belong to vertices that {wording.quoted(sorted(set(both.values())))} has too: "
                "what comes first in the list of handles carries them. Remove or turn off one of the two"
            )
        try:
            scene_input.gather(obj)
        except SceneError as problem:  # there is more to do before it can be posed
            notes.append(str(problem))
        if obj.meanvalue.baked.target:
            notes.append(shape_keys.BAKE_PLAYS)
        return _account(obj, matched), notes


def _account(obj, matched):
    follows = obj.meanvalue.live or obj.meanvalue.baked.target
    return [
        f"{wording.counted(len(matched.names), 'marker')} matched to '{obj.name}' at frame {matched.frame:g}"
        + ("" if follows else ". Press Live, or Bake"),
        f"They lie {_far(matched, matched.distance.mean())} from it on average, at most "
        f"{_far(matched, matched.distance.max())} ('{matched.names[int(matched.distance.argmax())]}')",
        *matched.told,
    ]


def _far(matched, distance):
    """A distance in the scene's unit and, since that may be any, over the mesh's size."""
    return f"{distance:.3g} ({wording.share(distance / matched.world_size)} of the mesh's size)"


class MEANVALUE_OT_pick_marker_point(picking.PickingOperator, bpy.types.Operator):
    """Click the point of the mesh where the active marker belongs. Match Markers keeps it"""

    bl_label = "Pick Marker Point"
    problems = (marker_pairs.list_problem,)
    switch = "remove"

    marker: bpy.props.StringProperty(
        name="Marker",
        description="Name of the marker. If empty: that of the active control or Empty, else the active line's",
    )
    vertex: bpy.props.IntProperty(name="Vertex", description="Vertex to choose; -1 to click at it", default=-1, min=-1)
    remove: bpy.props.BoolProperty(
        name="Remove Marker",
        description="Delete the marker's handle and control, and leave it out until its box is ticked again",
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
        if not self.remove:
            return self._picked(obj, pair)
        if bpy.context.object == pair.control:
            subject.choose(obj)
        marker_handles.drop(obj, pair)
        pair.is_used = pair.is_picked = False
        pair.vertex, pair.distance = -1, -1.0
        return f"'{pair.name}' moves the mesh no more. Tick it and press Match Markers to have it back", []

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
