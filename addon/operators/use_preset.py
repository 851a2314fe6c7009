# SPDX-License-Identifier: GPL-3.0-or-later
"""What presets call."""

import bpy
from bpy.props import FloatProperty, StringProperty

from .. import ids
from ..errors import SceneError
from .base import MeshOperator


class MEANVALUE_OT_use_preset(MeshOperator, bpy.types.Operator):
    """Set method and rigidity of the mesh that the artist works on"""

    bl_idname = "meanvalue.use_preset"
    bl_label = "Use Preset"
    bl_options = {'REGISTER', 'UNDO', 'INTERNAL'}
    needs_object_mode = False

    method: StringProperty(name="Method", description="How the shape is found", default=ids.METHOD_FAST)
    rigidity: FloatProperty(
        name="Rigidity",
        description="How much lengths count beside the local shape. 0 is the paper's energy, which lets parts "
        "grow and shrink freely. Only the method Fast knows it",
        default=ids.DEFAULT_RIGIDITY,
        min=0.0,
    )

    def run(self, obj):
        methods = obj.meanvalue.bl_rna.properties["method"].enum_items.keys()
        if self.method not in methods:
            raise SceneError(f"The preset names a method '{self.method}'. There are: {', '.join(methods)}")
        obj.meanvalue.method, obj.meanvalue.rigidity = self.method, self.rigidity
        return f"'{obj.name}': {self.method}, rigidity {self.rigidity:g}", []
