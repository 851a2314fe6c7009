# SPDX-License-Identifier: GPL-3.0-or-later
"""What posing adds to Blender, for registration.py."""

import bpy

from ..live import roll
from ..scene import subject
from ..widgets import overlay as painters
from . import old_files, properties
from .bridge import controls, moved_meshes, orphans, overlay_data
from .live.follower import Follower
from .operators import (
    add_handle,
    copy_system_info,
    drive_by_bone,
    finish,
    grab,
    handles,
    hover,
    pose,
    region,
    sample_rig_poses,
    select_problems,
    solve,
)
from .ui import grab_tool, keymap, menus, overlay, panel

PROPERTY_GROUPS = (*properties.PROPERTY_GROUPS, old_files.MEANVALUE_PG_anchor_group)
SETTINGS = {**properties.SETTINGS, **old_files.SETTINGS}

#: Of the guide, see addon/manual.py.
PAGE = "handles"
PAGES = {
    "meanvalue.grab": "grab",
    "meanvalue.grow_region": "region",
    "meanvalue.paint_region": "region",
    "meanvalue.select_problems": "messy_meshes",
}

CLASSES = (
    grab.MEANVALUE_OT_grab,
    add_handle.MEANVALUE_OT_add_handle,
    handles.MEANVALUE_OT_remove_handle,
    handles.MEANVALUE_OT_select_handle,
    handles.MEANVALUE_OT_reset_handles,
    handles.MEANVALUE_OT_keyframe_handles,
    select_problems.MEANVALUE_OT_select_problems,
    pose.MEANVALUE_OT_keep_pose,
    pose.MEANVALUE_OT_apply_pose,
    drive_by_bone.MEANVALUE_OT_drive_by_bone,
    finish.MEANVALUE_OT_finish,
    solve.MEANVALUE_OT_bind,
    solve.MEANVALUE_OT_unbind,
    solve.MEANVALUE_OT_solve,
    solve.MEANVALUE_OT_solve_from_key,
    region.MEANVALUE_OT_grow_region,
    region.MEANVALUE_OT_paint_region,
    sample_rig_poses.MEANVALUE_OT_sample_rig_poses,
    copy_system_info.MEANVALUE_OT_copy_system_info,
    *panel.CLASSES,
    *menus.CLASSES,
)
HOOKS = (
    (subject.finders, moved_meshes.mesh_moved_by),
    (painters.painters, overlay.paint),
    (roll.kinds, Follower),
    (bpy.types.VIEW3D_MT_object, menus.meanvalue_draw_object_menu),
    (bpy.types.VIEW3D_MT_edit_mesh, menus.meanvalue_draw_edit_mesh_menu),
)


def register():
    keymap.register()
    grab_tool.register()


def unregister():
    grab_tool.unregister()
    keymap.unregister()
    if bpy.app.timers.is_registered(orphans.remove):
        bpy.app.timers.unregister(orphans.remove)
    overlay.forget()
    forget()
    orphans.forget()


def scene_updated():
    hover.forget()  # it may be of another shape


def objects_changed():
    """Objects came or went."""
    moved_meshes.forget()
    if orphans.found() and not bpy.app.background and not bpy.app.timers.is_registered(orphans.remove):
        bpy.app.timers.register(orphans.remove, first_interval=0.0)
    old_files.carry_over(bpy.data.objects)


def chosen(active):
    """The artist made an object the active one, or took it to another mode."""
    controls.note_active(active)
    old_files.carry_over([active])


def another_file():
    orphans.forget()
    old_files.carry_over(bpy.data.objects)


def about_to_save():
    """In a file that is opened nobody knows which controls were deleted, and which are not there yet."""
    for obj in bpy.data.objects:
        if subject.object_problem(obj) is None and not obj.data.is_editmode:
            controls.remove_deleted(obj)


def forget():
    """Undo, redo or loading replaced everything that was read."""
    moved_meshes.forget()
    hover.forget()
    overlay_data.clear()
    orphans.note()
