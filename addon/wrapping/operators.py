# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits the mesh onto another one, whatever faces that has, by pairs of points that the artist shows."""

import bpy

from .. import wording
from ..errors import SceneError
from ..scene import subject
from ..widgets import picking
from ..widgets.background import BackgroundOperator
from .bridge import wrap_scene


class MEANVALUE_OT_pick_wrap_pairs(picking.PickingOperator, bpy.types.Operator):
    """Click a point of the mesh, then the same point of the other one, and so on until Enter. Begin with the ends"""

    bl_label = "Pick Pairs"
    bl_options = {'UNDO'}  # adjusted afterwards, it would pick anew
    switch = "clear"
    repeats = True
    problems = (lambda obj: None if obj.meanvalue.wrap.pairs else wrap_scene.target_problem(obj),)

    vertex: bpy.props.IntProperty(name="Vertex", description="Vertex of the mesh; -1 to click", default=-1, min=-1)
    place: bpy.props.FloatVectorProperty(name="Place", description="Where it belongs, in the other object's own space")
    clear: bpy.props.BoolProperty(name="Clear", description="Take all picked pairs back")

    def is_given(self):
        return self.clear or self.vertex >= 0

    def prompt(self, obj):
        target = wrap_scene.target_of(obj)
        what, where = ("a point", obj) if wrap_scene.begun is None else ("the same point", target)
        picked = wording.counted(len(obj.meanvalue.wrap.pairs), "pair")
        return f"Click {what} of '{where.name}'    {picked} picked    Backspace: Take Back    Enter: Done"

    def click(self, obj, view):
        if wrap_scene.begun is None:
            wrap_scene.begun = obj.name, picking.vertex_clicked(obj, view)
            return False
        self.place = picking.place_clicked(wrap_scene.target_of(obj), view)
        self.vertex, wrap_scene.begun = wrap_scene.begun[1], None
        return True

    def take_back(self, obj):
        """The half of a pair that was clicked, else the last pair."""
        pairs = obj.meanvalue.wrap.pairs
        if wrap_scene.begun is not None:
            wrap_scene.begun = None
            return False
        if pairs:
            pairs.remove(len(pairs) - 1)
        return True

    def end(self, context):
        wrap_scene.begun = None
        super().end(context)

    def run(self, obj):
        pairs = obj.meanvalue.wrap.pairs
        if self.clear:
            if not pairs:
                raise SceneError("No pairs are picked")
            pairs.clear()
            return f"The picked pairs of '{obj.name}' are taken back", []
        target = wrap_scene.target_of(obj)
        picking.require_vertex(obj, self.vertex)
        if any(pair.vertex == self.vertex for pair in pairs):
            raise SceneError(f"Vertex {self.vertex} has its place already. Choose another one, or clear the pairs")
        pair = pairs.add()
        pair.vertex, pair.place = self.vertex, self.place
        obj.meanvalue.wrap.target = target
        return f"Vertex {self.vertex} belongs there on '{target.name}': {wording.counted(len(pairs), 'pair')}", []


class MEANVALUE_OT_wrap(BackgroundOperator, bpy.types.Operator):
    """Fit the mesh onto another one, which may have other faces: its shape becomes a shape key here"""

    bl_label = "Wrap Mesh"
    doing = "Wrapping"
    problems = (wrap_scene.target_problem, wrap_scene.pairs_problem)
    switch = "carry"

    carry: bpy.props.BoolProperty(
        name="Carry Shape Keys",
        description="Give the mesh the shape keys of the other one, in its own proportions, as the last Wrap has it",
    )

    def prepare(self, obj):
        return (wrap_scene.Carrying if self.carry else wrap_scene.Wrapping)(obj, wrap_scene.target_of(obj))

    def job_progress(self):
        return super().job_progress() if self.carry else ("fitting", self._prepared.share)

    def finish(self, obj, prepared, found):
        target = bpy.data.objects[prepared.target_name]
        message, notes = (self._carried if self.carry else self._wrapped)(obj, target, prepared, found)
        return message, [*notes, *subject.sharing_notes(obj)]

    def _wrapped(self, obj, target, prepared, wrapped):
        name, notes = wrap_scene.write(obj, target, wrapped, prepared.whole), []
        distance = wrapped.distance[prepared.given.used] / prepared.given.diagonal
        if wrapped.flipped:
            flipped = wording.counted(wrapped.flipped, "triangle is", "triangles are")
            notes.append(f"{flipped} turned over. Pick pairs where they crowd")
        off = f"{distance.mean():.3%} of its size off on average, {distance.max():.2%} at most"
        return f"'{obj.name}' has the shape of '{target.name}' as shape key '{name}': {off}", notes

    def _carried(self, obj, source, prepared, offsets):
        undriven, notes = wrap_scene.write_carried(obj, source, offsets), []
        still = [each.name for each in prepared.sliders if each.name not in offsets]
        if undriven:
            notes.append(f"Not driven here: {wording.quoted(undriven, limit=12)}. Press Drive by Pose on each")
        if still:
            notes.append(f"Left out, as nothing moves here: {wording.quoted(still, limit=12)}")
        if prepared.left:
            notes.append(f"Here already: {wording.quoted(prepared.left, limit=12)}. Turn on Replace to write them")
        return f"{wording.counted(len(offsets), 'shape key')} of '{source.name}' carried onto '{obj.name}'", notes
