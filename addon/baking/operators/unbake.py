# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes back what Bake made, or lets it be the artist's own."""

import bpy
from bpy.props import BoolProperty

from ...posing.operators.finish import remove_what_was_made
from ...widgets.base import MeshOperator
from ..bridge import playing


class MEANVALUE_OT_unbake(MeshOperator, bpy.types.Operator):
    """Take back what Bake made, so that the mesh follows its handles again"""

    bl_label = "Remove Bake"
    switch = "keep_bake"
    problems = (lambda obj: None if obj.meanvalue.baked.target else f"'{obj.name}' is not baked",)

    keep_bake: BoolProperty(
        name="Keep Bake, Remove Handles",
        description="The bake stays and plays without the add-on; handles, pins and what was made for them go",
        options={'SKIP_SAVE'},
    )

    def run(self, obj):
        if self.keep_bake:
            playing.keep(obj)
            return f"The bake is kept. Removed: {remove_what_was_made(obj)}", []
        playing.take_back(obj)
        scene = bpy.context.scene
        scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)
        return "Removed the bake", []
