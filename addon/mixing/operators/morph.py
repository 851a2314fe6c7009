# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes the shape of another object as a slider that turns."""

import bpy
from bpy.props import BoolProperty, FloatProperty, StringProperty

from ... import ids
from ...errors import SceneError
from ...scene import shape_keys, subject, vertex_groups
from ...widgets.base import MeshOperator
from ..bridge import mix_layers, morph_source


class _FromObject(MeshOperator):
    """Mix-in: a shape key from another mesh with the same faces."""

    source: StringProperty(
        name="Source",
        description="Object whose shape is taken. Left empty: the other mesh that is selected",
        maxlen=ids.NAME_LENGTH,
    )
    name: StringProperty(
        name="Name", description="Name of the new shape key. Left empty: that of the source", maxlen=ids.NAME_LENGTH
    )
    value: FloatProperty(name="Value", description="Where the slider is at first", default=1.0, min=0.0, max=1.0)
    use_mix: BoolProperty(
        name="Rotation-Aware", description="Turn Rotation-Aware Keys on, so that it goes in arcs", default=True
    )

    group = ""

    def run(self, obj):
        source = self._source(obj)
        morph_source.require_alike(obj, source)
        if obj.data.shape_keys is not None and not obj.data.shape_keys.use_relative:
            raise SceneError(shape_keys.ABSOLUTE)
        if self.group:
            vertex_groups.require(obj, self.group, "the part", "Choose another group")
        shape = morph_source.shown_shape(source)
        name = morph_source.add_key(obj, shape, self.name.strip() or source.name, self.value, self.group)
        notes = []
        if self.use_mix and mix_layers.made_names(obj):
            notes.append(f"'{name}' goes in a straight line until you press Bake Mix again")
        elif self.use_mix:
            obj.meanvalue.mix.is_on = True
        where = f" in '{self.group}'" if self.group else ""
        return f"'{obj.name}' has the shape of '{source.name}'{where} as shape key '{name}', with its slider", notes

    def _source(self, obj):
        if self.source:
            source = bpy.data.objects.get(self.source)
            if source is None:
                raise SceneError(f"There is no object '{self.source}'. Choose another source")
            if source.type != 'MESH':
                raise SceneError(f"'{source.name}' is not a mesh. Choose another source")
            if source == obj:
                raise SceneError(f"'{obj.name}' is the mesh itself. Choose another source")
            return source
        others = morph_source.candidates(bpy.context, obj)
        if len(others) != 1:
            raise SceneError(
                f"{len(others)} other meshes are selected. Select one, then Shift-click '{obj.name}', so that it is "
                "the active one"
            )
        return others[0]


class MEANVALUE_OT_morph(_FromObject, bpy.types.Operator):
    bl_idname = "meanvalue.morph"
    bl_label = "Morph"
    bl_description = (
        "Take the shape of the other selected mesh as a shape key with a slider that turns instead of shrinking. "
        "Both need the same faces"
    )


class MEANVALUE_OT_blend_part(_FromObject, bpy.types.Operator):
    """Graft a part of the other selected mesh: the weights of a vertex group say where it enters. Soft edges blend"""

    bl_idname = "meanvalue.blend_part"
    bl_label = "Blend Part"

    group: StringProperty(
        name="Part",
        description="Vertex group of the part. Left empty: the active one",
        maxlen=ids.NAME_LENGTH,
    )

    @classmethod
    def problem(cls, obj):
        problem = super().problem(obj)
        if problem is None and not obj.vertex_groups:
            problem = "There is no vertex group that says where the part is. Select it in Edit Mode and assign a group"
        return problem

    def run(self, obj):
        if not self.group:
            self.group = obj.vertex_groups.active.name
        return super().run(obj)

    def invoke(self, context, _event):
        self.group = subject.of(context).vertex_groups.active.name
        return self.execute(context)
