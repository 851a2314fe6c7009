# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows the artist why a mesh is not symmetric."""

import bpy

from ... import wording
from ...errors import SceneError
from ...scene import mesh_arrays, mirrors, selection, shape_keys
from ...widgets.base import MeshOperator


class MEANVALUE_OT_select_unpaired(MeshOperator, bpy.types.Operator):
    """Select the vertices that have no mirror image across the axis of Symmetric, in Edit Mode"""

    bl_idname = "meanvalue.select_unpaired"
    bl_label = "Select Unpaired"

    def run(self, obj):
        axis = obj.meanvalue.symmetric
        if axis == 'NONE':
            raise SceneError("Symmetric is off. Choose an axis first")
        unpaired = mirrors.unpaired(obj, shape_keys.rest_positions(obj.data), *mesh_arrays.faces(obj.data))
        count = len(obj.data.vertices)
        if len(unpaired) == 0:
            return f"All {wording.vertices(count)} have a mirror image across {axis}", []
        selection.choose(obj)
        notes = selection.edit_with_selected(obj, unpaired)
        return f"{len(unpaired):,} of {wording.vertices(count)} have no mirror image across {axis}: selected", notes
