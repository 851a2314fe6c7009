# SPDX-License-Identifier: GPL-3.0-or-later
"""The submenus in Blender's menus Object and Mesh, and that of Apply."""

import bpy

from ... import ids
from ...scene import subject
from ...widgets import menus
from ..operators.add_handle import MEANVALUE_OT_add_handle
from ..operators.apply_pose import MEANVALUE_OT_apply_pose
from ..operators.bind import MEANVALUE_OT_bind
from ..operators.copy_system_info import MEANVALUE_OT_copy_system_info
from ..operators.drive_by_bone import MEANVALUE_OT_drive_by_bone
from ..operators.finish import MEANVALUE_OT_finish
from ..operators.grow_region import MEANVALUE_OT_grow_region
from ..operators.keep_pose import MEANVALUE_OT_keep_pose
from ..operators.keyframe_handles import MEANVALUE_OT_keyframe_handles
from ..operators.paint_region import MEANVALUE_OT_paint_region
from ..operators.remove_handle import MEANVALUE_OT_remove_handle
from ..operators.reset_handles import MEANVALUE_OT_reset_handles
from ..operators.select_handle import MEANVALUE_OT_select_handle
from ..operators.select_problems import MEANVALUE_OT_select_problems
from ..operators.solve import MEANVALUE_OT_solve
from ..operators.solve_from_key import MEANVALUE_OT_solve_from_key
from ..operators.unbind import MEANVALUE_OT_unbind


def draw_add(layout):
    """The two ways to hold the selected vertices."""
    layout.operator(MEANVALUE_OT_add_handle.bl_idname, icon='EMPTY_AXIS')
    layout.operator(MEANVALUE_OT_add_handle.bl_idname, text="Add Pin", icon='PINNED').pin = True


class MEANVALUE_MT_handles(bpy.types.Menu):
    """Hold the mesh, and move what is held"""

    bl_idname = "MEANVALUE_MT_handles"
    bl_label = "Handles"

    def draw(self, context):
        layout = self.layout
        draw_add(layout)
        menus.draw_operators(layout, (MEANVALUE_OT_select_handle, MEANVALUE_OT_remove_handle, None))
        obj = subject.of(context)
        if subject.object_problem(obj) is None:
            layout.prop(obj.meanvalue, "live")
        menus.draw_operators(layout, (MEANVALUE_OT_reset_handles, MEANVALUE_OT_keyframe_handles))


class MEANVALUE_MT_apply(bpy.types.Menu):
    """What becomes of the pose"""

    bl_idname = "MEANVALUE_MT_apply"
    bl_label = "Apply"

    def draw(self, _context):
        layout = self.layout
        layout.operator_context = 'INVOKE_DEFAULT'
        finish = MEANVALUE_OT_finish.bl_idname
        layout.operator(finish, text="Save as Shape Key", icon='SHAPEKEY_DATA').keep = 'SHAPE_KEY'
        layout.operator(MEANVALUE_OT_apply_pose.bl_idname, icon='MESH_DATA')
        layout.operator(finish, text="Apply and Finish", icon='CHECKMARK').keep = 'REST'
        layout.separator()
        layout.operator(finish, text="Cancel", icon='X').keep = 'NOTHING'


class MEANVALUE_MT_pose(bpy.types.Menu):
    """Keep the pose, or use it"""

    bl_idname = "MEANVALUE_MT_pose"
    bl_label = "Pose"

    def draw(self, _context):
        solve = (MEANVALUE_OT_solve, MEANVALUE_OT_solve_from_key, None)
        menus.draw_operators(self.layout, (*solve, MEANVALUE_OT_keep_pose, MEANVALUE_OT_drive_by_bone))
        self.layout.menu(MEANVALUE_MT_apply.bl_idname)


class MEANVALUE_MT_region(menus.OperatorMenu, bpy.types.Menu):
    """Which part of the mesh may move"""

    bl_idname = "MEANVALUE_MT_region"
    bl_label = "Region"
    operators = (MEANVALUE_OT_grow_region, MEANVALUE_OT_paint_region)


class MEANVALUE_MT_advanced(menus.OperatorMenu, bpy.types.Menu):
    """What everyday posing does without"""

    bl_idname = "MEANVALUE_MT_advanced"
    bl_label = "Advanced"
    operators = (
        MEANVALUE_OT_bind,
        MEANVALUE_OT_unbind,
        MEANVALUE_OT_select_problems,
        MEANVALUE_OT_copy_system_info,
    )


class MEANVALUE_MT_object(bpy.types.Menu):
    """Pose the mesh by handles"""

    bl_idname = "MEANVALUE_MT_object"
    bl_label = ids.SIDEBAR_TAB

    def draw(self, _context):
        own = (MEANVALUE_MT_handles, MEANVALUE_MT_pose, MEANVALUE_MT_region)
        for name in (*(menu.bl_idname for menu in own), *menus.of_rooms, MEANVALUE_MT_advanced.bl_idname):
            self.layout.menu(name)


class MEANVALUE_MT_edit_mesh(bpy.types.Menu):
    """Hold the mesh by the selected vertices"""

    bl_idname = "MEANVALUE_MT_edit_mesh"
    bl_label = ids.SIDEBAR_TAB

    def draw(self, _context):
        draw_add(self.layout)
        menus.draw_operators(self.layout, (MEANVALUE_OT_select_handle, MEANVALUE_OT_remove_handle))


def meanvalue_draw_object_menu(self, context):
    if subject.object_problem(subject.of(context)) is None:
        self.layout.separator()
        self.layout.menu(MEANVALUE_MT_object.bl_idname)


def meanvalue_draw_edit_mesh_menu(self, _context):
    self.layout.separator()
    self.layout.menu(MEANVALUE_MT_edit_mesh.bl_idname)


CLASSES = (
    MEANVALUE_MT_handles,
    MEANVALUE_MT_apply,
    MEANVALUE_MT_pose,
    MEANVALUE_MT_region,
    MEANVALUE_MT_advanced,
    MEANVALUE_MT_object,
    MEANVALUE_MT_edit_mesh,
)

_ENTRIES = (
    ("VIEW3D_MT_object", meanvalue_draw_object_menu),
    ("VIEW3D_MT_edit_mesh", meanvalue_draw_edit_mesh_menu),
)


def register():
    for menu, draw in _ENTRIES:
        getattr(bpy.types, menu).append(draw)


def unregister():
    for menu, draw in _ENTRIES:
        getattr(bpy.types, menu).remove(draw)
