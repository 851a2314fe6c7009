# SPDX-License-Identifier: GPL-3.0-or-later
"""What the artist has selected on a mesh."""

import bmesh
import bpy

from ..errors import SceneError
from . import pose_objects


def leave_edit_mode(obj):
    """To Object Mode, as an undo step of its own: those made in Edit Mode hold the edited mesh alone."""
    if obj.mode != 'EDIT':
        return
    bpy.ops.object.mode_set(mode='OBJECT')
    if bpy.ops.ed.undo_push.poll():
        bpy.ops.ed.undo_push(message="Leave Edit Mode")


def choose(obj):
    """Makes `obj` the only selected object, and the active one."""
    layer = bpy.context.view_layer
    obj = obj if obj.visible_get() else pose_objects.shown(obj)
    for other in layer.objects:
        if other is not None and other.select_get():  # None was deleted a moment ago
            other.select_set(False)
    if obj.name in layer.objects:
        obj.select_set(True)
        layer.objects.active = obj


def edit_with_selected(obj, vertices):
    """Goes to Edit Mode on the active object, where the vertices with these indices are selected and nothing else.
    Hidden ones, which could not be, are shown. Returns sentences on that. @throws SceneError."""
    if not obj.visible_get():
        raise SceneError(f"'{obj.name}' is hidden, so it cannot be edited. Show it first (the eye in the Outliner)")
    bpy.context.tool_settings.mesh_select_mode = (True, False, False)
    bpy.ops.object.mode_set(mode='EDIT')
    # Not before: writing whether edges are selected, also as an attribute, goes astray in Blender 5.0.1, or ends it.
    bpy.ops.mesh.select_all(action='DESELECT')
    edited = bmesh.from_edit_mesh(obj.data)
    edited.verts.ensure_lookup_table()
    wanted = [edited.verts[number] for number in vertices]
    shown_count = sum(vertex.hide for vertex in wanted)
    for vertex in wanted:
        vertex.hide = False
        vertex.select_set(True)
    edited.select_flush_mode()
    bmesh.update_edit_mesh(obj.data, loop_triangles=False, destructive=False)
    note = f"{shown_count:,} of them {'was' if shown_count == 1 else 'were'} hidden, and can be seen again"
    return [note] if shown_count else []
