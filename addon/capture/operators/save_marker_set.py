# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps the landmarks of a take's markers for other takes with the same names."""

import bpy

from ... import wording
from ...widgets.base import MeshOperator
from ..bridge import marker_pairs, marker_presets


class MEANVALUE_OT_save_marker_set(MeshOperator, bpy.types.Operator):
    """Keep the landmarks of all markers under a name: takes with markers of these names are known from then on"""

    bl_idname = "meanvalue.save_marker_set"
    bl_label = "Save Marker Set"
    needs_object_mode = False
    problems = (marker_pairs.list_problem,)

    name: bpy.props.StringProperty(name="Name", description="Name of the marker set", default="My Markers")

    def invoke(self, context, _event):
        return context.window_manager.invoke_props_dialog(self)

    def run(self, obj):
        path, count = marker_presets.save(self.name, obj.meanvalue.capture)
        return f"Marker set '{self.name}' has {wording.counted(count, 'marker')}, in {path}", []
