# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes shapes of other objects as sliders that turn, and makes shape keys that stand for a rotation-aware mix."""

import bpy
import numpy as np
from bpy.props import FloatProperty, StringProperty

from .. import wording
from ..errors import SceneError
from ..scene import mesh_arrays, shape_keys, subject, vertex_groups
from ..scene.core import motion, point_sets
from ..widgets.background import BackgroundOperator
from ..widgets.base import MeshOperator
from .bridge import mixed_keys
from .bridge.mix_follower import InBetweenSearch


class MEANVALUE_OT_morph(MeshOperator, bpy.types.Operator):
    """Take the shape of the other selected mesh as a shape key with a slider that turns instead of shrinking. Both \
need the same faces"""

    bl_label = "Morph to Selected"
    switch = "part"
    problems = (shape_keys.absolute_problem,)

    source: StringProperty(
        name="Source", description="Object whose shape is taken. Left empty: the other mesh that is selected"
    )
    part: StringProperty(
        name="Part",
        description="Graft a part of the other mesh, where this vertex group has weights. Left empty: the whole shape",
    )
    name: StringProperty(name="Name", description="Name of the new shape key. Left empty: that of the source")
    value: FloatProperty(name="Value", description="Where the slider is at first", default=1.0, min=0.0, max=1.0)

    def run(self, obj):
        source = bpy.data.objects.get(self.source)
        if source is None and self.source:
            raise SceneError(f"There is no object '{self.source}'. Choose another source")
        source = subject.other_mesh(bpy.context, obj, source)
        here, there = obj.data, source.data
        has = [f"has {len(mesh.vertices):,} vertices and {len(mesh.polygons):,} faces" for mesh in (there, here)]
        if has[0] != has[1] or not all(map(np.array_equal, mesh_arrays.faces(here), mesh_arrays.faces(there))):
            raise SceneError(
                f"'{source.name}' {has[0]}, '{obj.name}' {has[1]}. If their faces are not the same, use Wrap"
            )
        shape, is_laid = mixed_keys.shape_of(source, obj)
        if self.part:  # its border meets that of the mesh
            vertex_groups.require(obj, self.part, "the part", "Assign the part to one, and make it the active group")
            mask = vertex_groups.weights(obj, [self.part])[self.part]
            if not mask.any():
                group = f"The vertex group '{self.part}'"
                raise SceneError(f"{group} has no vertices with a weight above zero. Assign the part")
            border = point_sets.border(mask, mesh_arrays.edges(obj.data))
            shape = motion.placed(shape, shape_keys.rest_positions(obj.data), border)
        key = shape_keys.add_shape(obj, self.name.strip() or source.name, np.asarray(shape, np.float32))
        key.vertex_group, key.value = self.part, self.value
        name = key.name
        notes = []
        if is_laid and not self.part:
            notes.append(f"'{source.name}' stands elsewhere: its origin counts as that of '{obj.name}'")
        if mixed_keys.in_between_names(obj):
            notes.append(f"'{name}' goes in a straight line until you press Bake Mix again")
        else:
            obj.meanvalue.mix.is_on = True
        where = f" in '{self.part}'" if self.part else ""
        return f"'{obj.name}' has the shape of '{source.name}'{where} as shape key '{name}', with its slider", notes


#: Where the tolerance is not reached.
ADVICE = "Raise the tolerance, or bake the animation to a point cache"


def _problem(obj):
    """Why nothing can be baked, nor removed, in words, or None."""
    if obj.meanvalue.baked.target:
        return f"A bake of '{obj.name}' plays already. Press Remove Bake first"
    return None if mixed_keys.in_between_names(obj) else mixed_keys.problem(obj)


class MEANVALUE_OT_bake_mix(BackgroundOperator, bpy.types.Operator):
    """Make the in-between shape keys that the tolerance needs, driven by the sliders, to play without the add-on"""

    bl_label = "Bake Mix"
    switch = "remove"
    problems = (_problem,)
    doing = "Baking the mix of"

    remove: bpy.props.BoolProperty(
        name="Remove",
        description="Take away the in-between keys that are there. The sliders mix in straight lines then, or live",
    )

    def prepare(self, obj):
        if self.remove:
            return None
        mix_input = mixed_keys.gather(obj)
        tolerance = obj.meanvalue.mix.tolerance_share / 100.0 * mix_input.diagonal
        return InBetweenSearch(mix_input, tolerance)

    def progress_text(self, stage, share):
        solved = self._prepared.solved if self._prepared is not None else 0
        if not solved:
            return super().progress_text(stage, share)
        return f"{wording.counted(solved, 'mix', 'mixes')} solved    Esc: Cancel"

    def finish(self, obj, prepared, found):
        if self.remove:
            count = mixed_keys.remove_in_betweens(obj)
            if count == 0:
                raise SceneError(f"'{obj.name}' has no in-between keys of Bake Mix")
            obj.data.update_tag()
            return f"Removed {wording.counted(count, 'in-between key')} of '{obj.name}'", []
        share = found.error / prepared.bind_input.diagonal if prepared.bind_input.diagonal else 0.0
        is_near = found.error <= prepared.tolerance
        if not found.shapes and not is_near:
            raise SceneError(f"No in-between key brings the mix of '{obj.name}' nearer than straight lines. {ADVICE}")
        if not found.shapes:
            text = f"No in-between keys are needed: in straight lines the mix is within {share:.2%} of the size"
            removed = mixed_keys.remove_in_betweens(obj)
            if not removed:
                raise SceneError(text)
            return text, [f"Removed {wording.counted(removed, 'key')} that stood for a former mix"]
        obj.meanvalue.mix.is_on = False
        mixed_keys.make_in_betweens(obj, prepared.bind_input, found)
        made = wording.counted(len(found.shapes), "in-between key")
        text = f"'{obj.name}' has {made}, within {share:.2%} of the mesh's size, driven by its sliders"
        return text, [] if is_near else [f"That is more than the tolerance. {ADVICE}"]
