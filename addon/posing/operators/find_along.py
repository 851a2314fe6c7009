# SPDX-License-Identifier: GPL-3.0-or-later
"""Has more objects go along with the mesh."""

import bpy

from ... import wording
from ...scene import along, worn
from ...widgets.base import MeshOperator


class MEANVALUE_OT_find_along(MeshOperator, bpy.types.Operator):
    """List the children of the mesh, the meshes on its armature, and selected ones that lie on it"""

    bl_label = "Find"
    needs_object_mode = False

    def run(self, obj):
        worn.remove_deleted(obj)
        found = worn.find(obj)
        obj.update_tag()
        return f"{wording.counted(found, 'object')} found", along.problems(obj)
