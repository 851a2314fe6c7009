# SPDX-License-Identifier: GPL-3.0-or-later
"""What posing adds to Blender, for registration.py."""

import bpy

from ..rooms import Room
from ..scene import along, subject, worn
from ..scene.pose_object_making import take_over_rests
from . import old_files, properties
from .bridge import controls, orphans
from .live.follower import Follower
from .operators import advanced, drive_by_bone, grab, handles, pose, tool_choice
from .ui import menus, overlay, panel


def _unregister():
    menus.unregister()
    if bpy.app.timers.is_registered(orphans.remove):
        bpy.app.timers.unregister(orphans.remove)
    for forget in (*ROOM.forget, orphans.forget):
        forget()


def _remove_orphans():
    if orphans.found() and not bpy.app.background and not bpy.app.timers.is_registered(orphans.remove):
        bpy.app.timers.register(orphans.remove, first_interval=0.0)


def _remove_deleted():
    """In a file that is opened nobody knows which controls were deleted, and which are not there yet."""
    meshes = [each for each in bpy.data.objects if subject.object_problem(each) is None and not each.data.is_editmode]
    for obj in meshes:  # bpy.data.objects goes on from one that is freed, as the control of the mesh before it
        controls.remove_deleted(obj)
        worn.remove_deleted(obj)


ROOM = Room(
    page="handles",
    pages={
        "meanvalue.grab": "grab",
        "meanvalue.find_along": "clothes",
        "meanvalue.grow_region": "region",
        "meanvalue.paint_region": "region",
        "meanvalue.select_problems": "messy_meshes",
    },
    modules=(properties, grab, handles, pose, drive_by_bone, advanced, panel, menus),
    settings=properties.Settings.__annotations__,
    register=menus.register,
    unregister=_unregister,
    finders=[controls.mesh_moved_by],
    painters=[overlay.paint],
    followers=[Follower],
    blender_menus=[
        (bpy.types.VIEW3D_MT_object, menus.meanvalue_draw_object_menu),
        (bpy.types.VIEW3D_MT_edit_mesh, menus.meanvalue_draw_edit_mesh_menu),
    ],
    scene_updated=[tool_choice.forget_hover],  # it may be of another shape
    objects_changed=[controls.forget_moved_meshes, worn.forget, _remove_orphans, take_over_rests, old_files.carry_over],
    chosen=[controls.note_active, old_files.carry_over],
    another_file=[orphans.forget, take_over_rests, old_files.carry_over],
    about_to_save=[_remove_deleted],
    forget=[controls.forget_moved_meshes, along.forget, tool_choice.forget_hover, overlay.forget, orphans.note],
)
