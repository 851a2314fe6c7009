# SPDX-License-Identifier: GPL-3.0-or-later
"""The submenus in Blender's menus Object and Mesh, and that of Apply."""

import bpy

from ... import ids
from ...rooms import ALL
from ...scene import subject
from ...widgets import panels


def draw_add(layout):
    """The two ways to hold the selected vertices."""
    layout.operator("meanvalue.add_handle", icon='EMPTY_AXIS')
    layout.operator("meanvalue.add_handle", text="Add Pin", icon='PINNED').pin = True


class MEANVALUE_MT_handles(bpy.types.Menu):
    """Hold the mesh, move what is held, and say what may follow"""

    bl_label = "Handles"

    def draw(self, context):
        layout = self.layout
        draw_add(layout)
        panels.draw_operators(layout, ("meanvalue.select_handle", "meanvalue.remove_handle", None))
        obj = subject.of(context)
        if subject.object_problem(obj) is None:
            layout.prop(obj.meanvalue, "live")
        panels.draw_operators(layout, ("meanvalue.reset_handles", "meanvalue.keyframe_handles", None))
        panels.draw_operators(layout, ("meanvalue.grow_region", "meanvalue.paint_region", "meanvalue.find_along"))


class MEANVALUE_MT_apply(bpy.types.Menu):
    """What becomes of the pose"""

    bl_label = "Apply"

    def draw(self, _context):
        layout = self.layout
        layout.operator_context = 'INVOKE_DEFAULT'
        finish = "meanvalue.finish"
        layout.operator(finish, text="Save as Shape Key", icon='SHAPEKEY_DATA').keep = 'SHAPE_KEY'
        layout.operator("meanvalue.apply_pose", icon='MESH_DATA')
        layout.operator(finish, text="Apply and Finish", icon='CHECKMARK').keep = 'REST'
        layout.separator()
        layout.operator(finish, text="Discard Pose and Handles", icon='X').keep = 'NOTHING'


class MEANVALUE_MT_pose(bpy.types.Menu):
    """Keep the pose, or use it; and what everyday posing does without"""

    bl_label = "Pose"

    def draw(self, _context):
        panels.draw_operators(self.layout, ("meanvalue.keep_pose", "meanvalue.drive_by_bone"))
        self.layout.operator_menu_enum("meanvalue.drive_by_bone", "does", text="Kept Pose")
        self.layout.menu(MEANVALUE_MT_apply.__name__)
        panels.draw_operators(self.layout, (None, "meanvalue.bind", "meanvalue.solve_from_key", None))
        panels.draw_operators(
            self.layout, ("meanvalue.sample_rig_poses", "meanvalue.select_problems", "meanvalue.copy_system_info")
        )


class MEANVALUE_MT_object(bpy.types.Menu):
    """Pose the mesh by handles"""

    bl_label = ids.SIDEBAR_TAB

    def draw(self, _context):
        for menu in (MEANVALUE_MT_handles, MEANVALUE_MT_pose, *ALL.menus):
            self.layout.menu(menu.__name__)


def meanvalue_draw_object_menu(self, context):
    if subject.object_problem(subject.of(context)) is None:
        self.layout.separator()
        self.layout.menu(MEANVALUE_MT_object.__name__)


def meanvalue_draw_edit_mesh_menu(self, _context):
    self.layout.separator()
    self.layout.menu(MEANVALUE_MT_handles.__name__, text=ids.SIDEBAR_TAB)
