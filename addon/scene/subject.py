# SPDX-License-Identifier: GPL-3.0-or-later
"""The object that the artist works on, why it cannot be worked on, and what is selected."""

import bmesh
import bpy
import numpy as np

from .. import wording
from ..errors import SceneError
from ..rooms import ALL
from . import pose_objects
from .core import motion


def of(context):
    """The object that the artist works on: the active one, the mesh that it stands for, or its pose object; or None."""
    active = context.object
    if active is not None and active.type != 'MESH':
        active = next(filter(None, (find(active) for find in ALL.finders)), active)
    return pose_objects.of(active) or active


def object_problem(obj):
    """Why `obj` cannot be worked on at all, or None. Cheap: operators ask it in poll()."""
    if obj is None:
        return "There is no active object. Click a mesh object"
    if obj.type != 'MESH':
        if obj.instance_collection is not None:
            how = "an override (Object > Library Override > Make), or real objects (Object > Apply)"
            return f"'{obj.name}' stands for a collection. Make it {how}"
        return f"'{obj.name}' is not a mesh. Click a mesh object"
    if obj.library is not None:
        return f"'{obj.name}' is linked from another file. Make it an override (Object > Library Override > Make)"
    if pose_objects.is_foreign(obj):
        return f"'{obj.name}' is of another file. Press on it with Grab, which makes an object here that holds its pose"
    return pose_objects.problem(obj)


def problem_to_begin(obj):
    """As object_problem(), but for what can be made ready by pose_object_making.py."""
    return None if pose_objects.is_foreign(obj) else object_problem(obj)


def mode_problem(obj):
    """Why the object's mode is in the way, or None. Blender's mesh data is only up to date in Object Mode."""
    if obj.mode != 'OBJECT':
        return f"'{obj.name}' is in {mode_name(obj.mode)}. Go back to Object Mode"
    if obj.data.is_editmode:
        return f"The mesh of '{obj.name}' is in Edit Mode, by another object that has it. Leave that first"
    return None


def mode_name(mode):
    name = bpy.types.Object.bl_rna.properties["mode"].enum_items[mode].name
    return f"{name.removesuffix(' Mode')} Mode"


def sharing_notes(obj):
    """Sentences: one if other objects use the mesh too."""
    others = obj.data.users - int(obj.data.use_fake_user) - 1
    if others > 0:
        return [f"The mesh is shared with {wording.counted(others, 'other object')}, where the result shows too"]
    return []


def other_mesh(context, obj, chosen=None):
    """The mesh whose shape `obj` takes: `chosen`, or else the other one that is selected. @throws SceneError."""
    own = obj, pose_objects.shown(obj)
    if chosen is None:
        others = [other for other in context.selected_objects if other not in own and other.type == 'MESH']
        if len(others) != 1:
            raise SceneError(f"{len(others)} other meshes are selected. Select one, then Shift-click '{obj.name}'")
        return others[0]
    if chosen.type != 'MESH' or chosen in own:
        raise SceneError(f"'{chosen.name}' is no other mesh. Choose one whose shape '{obj.name}' can take")
    return chosen


def to_world(obj):
    """4 x 4 float64. @throws SceneError if it cannot be undone."""
    matrix = np.array(obj.matrix_world, np.float64)
    if motion.is_flat(matrix):
        raise SceneError(f"'{obj.name}' is scaled to nothing. Give it a size")
    return matrix


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
    # Not context.tool_settings: Blender leaves its scene's address in bpy.context, and writes there after it is freed.
    bpy.context.scene.tool_settings.mesh_select_mode = (True, False, False)
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
