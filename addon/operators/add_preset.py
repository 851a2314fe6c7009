# SPDX-License-Identifier: GPL-3.0-or-later
"""Stores the way of posing as a preset of the artist's own, and removes such presets."""

import pathlib

import bpy
from bl_operators.presets import AddPresetBase

from .. import ids
from ..bridge import scene_input
from ..core import wording

#: What a preset holds.
SETTINGS = ("method", "rigidity")

#: What a preset says: a file knows operators, but not where the add-on is installed.
PRESET = """import bpy

bpy.ops.meanvalue.use_preset({})
"""


class MEANVALUE_OT_add_preset(AddPresetBase, bpy.types.Operator):
    """Store method and rigidity as a preset, or remove one that you stored"""

    bl_idname = "meanvalue.add_preset"
    bl_label = "Add Preset"
    preset_menu = ids.PRESETS_PANEL
    preset_subdir = ids.PRESETS_FOLDER

    @classmethod
    def poll(cls, context):
        problem = scene_input.object_problem(scene_input.subject(context))
        if problem:
            cls.poll_message_set(wording.sentence(problem))
        return problem is None

    def execute(self, context):
        if self.remove_name:
            if not self._is_stored():
                problem = f"You have stored no preset '{self.name}'. Those that come with the add-on cannot be removed"
                self.report({'ERROR'}, wording.sentence(problem))
                return {'CANCELLED'}
        elif not self.as_filename(self.name):
            self.report({'ERROR'}, "The preset has no name. Give it one of letters or digits.")
            return {'CANCELLED'}
        return super().execute(context)

    def add(self, context, filepath):
        """Called by Blender's own part to write the file, which it cannot do itself in 4.3 under Python 3.13."""
        settings = scene_input.subject(context).meanvalue
        values = ", ".join(f"{name}={getattr(settings, name)!r}" for name in SETTINGS)
        pathlib.Path(filepath).write_text(PRESET.format(values), encoding="utf-8")

    def _is_stored(self):
        return any(
            bpy.utils.preset_find(self.name, self.preset_subdir, display_name=is_title)
            for is_title in (False, True)
        )
