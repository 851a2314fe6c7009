# SPDX-License-Identifier: GPL-3.0-or-later
"""The submenus in Blender's menus Object and Mesh."""

import bpy

from ... import ids
from ...scene import subject
from ...widgets import menus
from ..operators.add_handle import MEANVALUE_OT_add_handle, MEANVALUE_OT_add_pin
from ..operators.apply_pose import MEANVALUE_OT_apply_pose
from ..operators.bind import MEANVALUE_OT_bind
from ..operators.copy_system_info import MEANVALUE_OT_copy_system_info
from ..operators.finish import MEANVALUE_OT_finish
from ..operators.grow_region import MEANVALUE_OT_grow_region
from ..operators.keep_pose import MEANVALUE_OT_keep_pose
from ..operators.keyframe_handles import MEANVALUE_OT_keyframe_handles
from ..operators.own_controls import MEANVALUE_OT_own_controls
from ..operators.paint_region import MEANVALUE_OT_paint_region
from ..operators.remove_handle import MEANVALUE_OT_remove_handle
from ..operators.reset_handles import MEANVALUE_OT_reset_handles
from ..operators.select_handle import MEANVALUE_OT_select_handle
from ..operators.select_problems import MEANVALUE_OT_select_problems
from ..operators.select_unpaired import MEANVALUE_OT_select_unpaired
from ..operators.solve import MEANVALUE_OT_solve
from ..operators.solve_from_key import MEANVALUE_OT_solve_from_key
from ..operators.toggle_live import MEANVALUE_OT_toggle_live
from ..operators.unbind import MEANVALUE_OT_unbind

#: None draws a line.
_OBJECT_OPERATORS = (
    MEANVALUE_OT_toggle_live,
    MEANVALUE_OT_reset_handles,
    None,
    MEANVALUE_OT_add_handle,
    MEANVALUE_OT_add_pin,
    MEANVALUE_OT_select_handle,
    MEANVALUE_OT_select_problems,
    MEANVALUE_OT_select_unpaired,
    MEANVALUE_OT_own_controls,
    MEANVALUE_OT_remove_handle,
    None,
    MEANVALUE_OT_grow_region,
    MEANVALUE_OT_paint_region,
    None,
    MEANVALUE_OT_bind,
    MEANVALUE_OT_unbind,
    MEANVALUE_OT_solve,
    MEANVALUE_OT_solve_from_key,
    None,
    MEANVALUE_OT_keep_pose,
    MEANVALUE_OT_apply_pose,
    MEANVALUE_OT_keyframe_handles,
    MEANVALUE_OT_finish,
    None,
    MEANVALUE_OT_copy_system_info,
)
_EDIT_OPERATORS = (
    MEANVALUE_OT_add_handle,
    MEANVALUE_OT_add_pin,
    MEANVALUE_OT_select_handle,
    MEANVALUE_OT_remove_handle,
)


class MEANVALUE_MT_object(bpy.types.Menu):
    """Pose the mesh by handles"""

    bl_idname = "MEANVALUE_MT_object"
    bl_label = ids.SIDEBAR_TAB

    def draw(self, _context):
        menus.draw_operators(self.layout, _OBJECT_OPERATORS)
        self.layout.separator()
        for name in menus.of_rooms:
            self.layout.menu(name)


class MEANVALUE_MT_edit_mesh(menus.OperatorMenu, bpy.types.Menu):
    """Hold the mesh by the selected vertices"""

    bl_idname = "MEANVALUE_MT_edit_mesh"
    bl_label = ids.SIDEBAR_TAB
    operators = _EDIT_OPERATORS


def meanvalue_draw_object_menu(self, context):
    if subject.object_problem(subject.of(context)) is None:
        self.layout.separator()
        self.layout.menu(MEANVALUE_MT_object.bl_idname)


def meanvalue_draw_edit_mesh_menu(self, _context):
    self.layout.separator()
    self.layout.menu(MEANVALUE_MT_edit_mesh.bl_idname)


CLASSES = (MEANVALUE_MT_object, MEANVALUE_MT_edit_mesh)

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
