# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes back what Bake made."""

import contextlib
import pathlib

import bpy
from bpy.props import BoolProperty

from ...scene.core.checked_json import read_json
from ...widgets.base import MeshOperator
from ..bridge import baking, playing
from ..properties import TO_CACHE


class MEANVALUE_OT_unbake(MeshOperator, bpy.types.Operator):
    """Take back what Bake made, so that the mesh follows its handles again"""

    bl_idname = "meanvalue.unbake"
    bl_label = "Remove Bake"

    delete_files: BoolProperty(
        name="Delete File",
        description="Delete the point cache from the disk, too. That cannot be undone",
        options={'SKIP_SAVE'},
    )

    @classmethod
    def problem(cls, obj):
        problem = super().problem(obj)
        if problem is None and not obj.meanvalue.baked.target:
            problem = f"'{obj.name}' is not baked"
        return problem

    def run(self, obj):
        record = obj.meanvalue.baked
        shown_path = record.path if record.target == TO_CACHE else ""
        path = pathlib.Path(bpy.path.abspath(shown_path)) if shown_path else None
        removed = playing.take_back(obj)
        bpy.context.scene.frame_set(bpy.context.scene.frame_current, subframe=bpy.context.scene.frame_subframe)
        notes = []
        if path is not None:
            notes.append(self._files(obj, path, shown_path))
        return ". ".join([f"Removed {removed} of '{obj.name}'", *notes]), []

    def _files(self, obj, path, shown_path):
        """What became of the cache. A copy of an object never deletes the original's."""
        marker = read_json(baking.report_path(path)) or {}
        if not self.delete_files or marker.get("object") != obj.name:
            return f"The file '{shown_path}' stays: Bake takes it again as long as nothing has changed"
        with contextlib.suppress(OSError):
            path.unlink()
            baking.report_path(path).unlink()
        return f"'{shown_path}' could not be deleted" if path.exists() else f"'{shown_path}' is deleted"
