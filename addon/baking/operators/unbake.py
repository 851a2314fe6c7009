# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes back what Bake made, or lets it be the artist's own."""

import contextlib
import pathlib

import bpy
from bpy.props import BoolProperty

from ...posing.operators.finish import remove_what_was_made
from ...widgets.base import MeshOperator
from ..bridge import playing
from ..core import point_cache


class MEANVALUE_OT_unbake(MeshOperator, bpy.types.Operator):
    """Take back what Bake made, so that the mesh follows its handles again"""

    bl_idname = "meanvalue.unbake"
    bl_label = "Remove Bake"

    delete_files: BoolProperty(
        name="Delete File",
        description="Delete the point cache from the disk, too. That cannot be undone",
        options={'SKIP_SAVE'},
    )
    keep_bake: BoolProperty(
        name="Keep Bake, Remove Handles",
        description="The bake stays and plays without the add-on; handles, pins and what was made for them go",
        options={'SKIP_SAVE'},
    )

    @classmethod
    def description(cls, _context, properties):
        return cls.bl_rna.properties["keep_bake"].description if properties.keep_bake else cls.__doc__

    @classmethod
    def problem(cls, obj):
        problem = super().problem(obj)
        if problem is None and not obj.meanvalue.baked.target:
            problem = f"'{obj.name}' is not baked"
        return problem

    def run(self, obj):
        if self.keep_bake:
            playing.keep(obj)
            return f"The bake is kept. Removed: {remove_what_was_made(obj)}", []
        shown_path = obj.meanvalue.baked.path
        removed = playing.take_back(obj)
        scene = bpy.context.scene
        scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)
        notes = [_delete(obj, shown_path)] if shown_path and self.delete_files else []
        return ". ".join([f"Removed {removed}", *notes]), []


def _delete(obj, shown_path):
    """What became of the cache. A copy of an object never deletes the original's."""
    path = pathlib.Path(bpy.path.abspath(shown_path))
    marker = point_cache.read_marker(path)
    if marker.get("object") != obj.name:
        return f"'{shown_path}' is of another object, and stays"
    with contextlib.suppress(OSError):
        path.unlink()
        point_cache.marker_path(path).unlink()
    return f"'{shown_path}' could not be deleted" if path.exists() else f"'{shown_path}' is deleted"
