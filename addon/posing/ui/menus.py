# SPDX-License-Identifier: GPL-3.0-or-later
"""What posing adds to Blender's own interface: submenus of Object and Mesh, and that of Apply; the tool in the toolbar,
its cursor and what the status bar says of it; and shortcuts that are free in Blender's own keymap: what the artist
changes of them in Preferences Blender keeps beside what is registered here."""

import bpy

from ... import ids
from ...rooms import ALL
from ...scene import subject
from ...widgets import panels
from ..bridge import region
from ..operators import tool_choice


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


#: Fainter than while something is dragged: how far the mesh is from the eye under the mouse is not known yet.
HOVER_COLOR = (1.0, 1.0, 1.0, 0.35)


class MeanValueGrabTool(bpy.types.WorkSpaceTool):
    bl_space_type = 'VIEW_3D'
    bl_context_mode = 'OBJECT'
    bl_idname = "meanvalue.grab"
    bl_label = "Mean-Value Grab"
    bl_description = "Press on a mesh and drag. The wheel says how much follows. Shift-click pins, a click selects"
    bl_icon = "brush.uv_sculpt.grab"  # of those that Blender has from 3.4 to 5.x
    bl_cursor = 'CROSSHAIR'
    bl_keymap = (
        ("meanvalue.grab", {"type": 'LEFTMOUSE', "value": 'PRESS'}, None),
        ("meanvalue.grab", {"type": 'LEFTMOUSE', "value": 'PRESS', "shift": True}, {"properties": [("pin", True)]}),
    )

    def draw_settings(context, layout, tool):  # noqa: N805  Blender calls it without an instance
        layout.prop(tool.operator_properties("meanvalue.grab"), "size")

    def draw_cursor(context, tool, mouse):  # noqa: N805
        obj = subject.of(context)
        view = context.region_data
        if tool_choice.is_shown or view is None or subject.object_problem(obj) is not None:
            return
        tool_choice.mouse_at(context, mouse)
        found = tool_choice.would_follow(context, obj)
        size = tool.operator_properties("meanvalue.grab").size if found is None else found.size
        length = size * region.shown_size(obj) * max(map(abs, obj.matrix_world.to_scale()))
        place = obj.matrix_world.translation if found is None else found.place
        tool_choice.draw(mouse, HOVER_COLOR, tool_choice.pixels(context.region, view, place, length))


def meanvalue_draw_status(header, context):
    """What Blender's status bar, which knows one key a tool, leaves out."""
    if context.workspace is not None and tool_choice.is_active(context) and not tool_choice.is_shown:
        header.layout.label(text="Drag: Grab    Shift-Click: Pin    Click: Select    Wheel in the Drag: Size")


def register():
    """Not without a window: Blender has no keymap then when it turns on the add-ons of the preferences."""
    setattr(bpy.types.Scene, LIVE, bpy.props.BoolProperty(name="Live", get=_is_live, set=_turn_live))
    if not bpy.app.background:
        bpy.utils.register_tool(MeanValueGrabTool, after={"builtin.transform"}, separator=True)
        bpy.types.STATUSBAR_HT_header.prepend(meanvalue_draw_status)
    keyconfig = bpy.context.window_manager.keyconfigs.addon
    for name, operator, properties, key, modifiers in () if keyconfig is None else SHORTCUTS:
        keymap = keyconfig.keymaps.new(name=name)
        item = keymap.keymap_items.new(operator, key, 'PRESS', **modifiers)
        _made.append((keymap, item))
        for each, value in properties.items():
            setattr(item.properties, each, value)


def unregister():
    if not bpy.app.background:
        bpy.types.STATUSBAR_HT_header.remove(meanvalue_draw_status)
        bpy.utils.unregister_tool(MeanValueGrabTool)
    delattr(bpy.types.Scene, LIVE)
    while _made:
        keymap, item = _made.pop()
        keymap.keymap_items.remove(item)


#: For wm.context_toggle: Live of the mesh that is worked on, also while one of its controls is the active object.
LIVE = "meanvalue_live"

#: (keymap, operator, its properties, key, modifiers)
SHORTCUTS = (
    ("Object Mode", "wm.context_toggle", {"data_path": f"scene.{LIVE}"}, 'L', {"alt": True}),
    ("Object Mode", "meanvalue.reset_handles", {}, 'L', {"alt": True, "shift": True}),
    ("Mesh", "meanvalue.add_handle", {}, 'H', {"ctrl": True, "alt": True}),
    ("Mesh", "meanvalue.add_handle", {"pin": True}, 'P', {"ctrl": True, "alt": True}),
)

_made = []  # (keymap, item)


def _is_live(_scene):
    obj = subject.of(bpy.context)
    return subject.object_problem(obj) is None and obj.meanvalue.live


def _turn_live(_scene, is_on):
    obj = subject.of(bpy.context)
    if subject.object_problem(obj) is None and (obj.meanvalue.handles or not is_on):
        obj.meanvalue.live = is_on
