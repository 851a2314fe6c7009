# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes the shape of another object, or of a part of it, as a slider that turns."""

import bpy
from bpy.props import FloatProperty, StringProperty

from ... import ids
from ...errors import SceneError
from ...scene import shape_keys, subject, vertex_groups
from ...widgets.base import MeshOperator
from ..bridge import mixed_keys, morph_source


class MEANVALUE_OT_morph(MeshOperator, bpy.types.Operator):
    """Take the shape of the other selected mesh as a shape key with a slider that turns instead of shrinking. Both \
need the same faces"""

    bl_label = "Morph to Selected"
    switch = "part"
    problems = (shape_keys.absolute_problem,)

    source: StringProperty(
        name="Source",
        description="Object whose shape is taken. Left empty: the other mesh that is selected",
        maxlen=ids.NAME_LENGTH,
    )
    part: StringProperty(
        name="Part",
        description="Graft a part of the other mesh, where this vertex group has weights. Left empty: the whole shape",
        maxlen=ids.NAME_LENGTH,
        options={'SKIP_SAVE'},
    )
    name: StringProperty(
        name="Name", description="Name of the new shape key. Left empty: that of the source", maxlen=ids.NAME_LENGTH
    )
    value: FloatProperty(name="Value", description="Where the slider is at first", default=1.0, min=0.0, max=1.0)

    def run(self, obj):
        source = bpy.data.objects.get(self.source)
        if source is None and self.source:
            raise SceneError(f"There is no object '{self.source}'. Choose another source")
        source = subject.other_mesh(bpy.context, obj, source)
        morph_source.require_alike(obj, source)
        if self.part:
            vertex_groups.require(obj, self.part, "the part", "Assign the part to one, and make it the active group")
        shape, is_laid = morph_source.in_place(morph_source.shown_shape(source), obj, source)
        name = morph_source.add_key(obj, shape, self.name.strip() or source.name, self.value, self.part)
        notes = []
        if is_laid and not self.part:
            notes.append(f"'{source.name}' stands elsewhere: its origin counts as that of '{obj.name}'")
        if mixed_keys.in_between_names(obj):
            notes.append(f"'{name}' goes in a straight line until you press Bake Mix again")
        else:
            obj.meanvalue.mix.is_on = True
        where = f" in '{self.part}'" if self.part else ""
        return f"'{obj.name}' has the shape of '{source.name}'{where} as shape key '{name}', with its slider", notes
