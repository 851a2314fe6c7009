# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidebar panel and its parts."""

import bpy

from ... import ids, wording
from ...live import engine
from ...scene import shape_keys, subject
from ...solver import native_loader
from ...widgets import overlay, panels
from ...widgets.panels import PanelPart, SidebarPanel
from ...widgets.text_box import draw_wrapped
from ..bridge import bound_record, controls, object_status, targets
from ..bridge.object_status import State
from ..operators.add_handle import MEANVALUE_OT_add_handle, MEANVALUE_OT_add_pin
from ..operators.apply_pose import MEANVALUE_OT_apply_pose
from ..operators.bind import MEANVALUE_OT_bind
from ..operators.copy_system_info import MEANVALUE_OT_copy_system_info
from ..operators.finish import MEANVALUE_OT_finish
from ..operators.grab import MEANVALUE_OT_grab
from ..operators.grow_region import MEANVALUE_OT_grow_region
from ..operators.keep_pose import MEANVALUE_OT_keep_pose
from ..operators.keyframe_handles import MEANVALUE_OT_keyframe_handles
from ..operators.own_controls import MEANVALUE_OT_own_controls
from ..operators.paint_region import MEANVALUE_OT_finish_region, MEANVALUE_OT_paint_region
from ..operators.remove_handle import MEANVALUE_OT_remove_handle
from ..operators.reset_handles import MEANVALUE_OT_reset_handles
from ..operators.select_problems import MEANVALUE_OT_select_problems
from ..operators.solve import MEANVALUE_OT_solve
from ..operators.solve_from_key import MEANVALUE_OT_solve_from_key
from ..operators.unbind import MEANVALUE_OT_unbind
from .handle_list import MEANVALUE_UL_handles

STATE_ICONS = {
    State.UNBOUND: 'RADIOBUT_OFF',
    State.BOUND: 'CHECKMARK',
    State.STALE: 'FILE_REFRESH',
    State.PROBLEM: 'ERROR',
}


class MEANVALUE_PT_panel(SidebarPanel, bpy.types.Panel):
    """Pose the mesh by handles: what holds it, and whether it follows"""

    bl_idname = "MEANVALUE_PT_panel"
    bl_label = "Mean-Value"

    def draw(self, context):
        layout = self.layout
        obj = subject.of(context)
        problem = native_loader.problem()
        if problem:
            draw_wrapped(layout.box(), context, wording.sentence(problem), icon='ERROR')
        problem = subject.object_problem(obj)
        if problem:
            draw_wrapped(layout, context, wording.sentence(problem), icon='INFO')
            return
        if overlay.problem:
            draw_wrapped(layout, context, wording.sentence(overlay.problem), icon='ERROR')
        if any(draw_top(layout, context, obj) for draw_top in panels.tops):
            return
        status = object_status.status(obj, object_status.QUIET_SECONDS)
        _draw_live(layout, obj)
        _draw_handles(layout, obj)
        _draw_status(layout, context, obj, status)


class MEANVALUE_PT_active_handle(PanelPart, bpy.types.Panel):
    """What the active handle holds and follows"""

    bl_label = "Active Handle"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and _active_handle(subject.of(context)) is not None

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        obj = subject.of(context)
        handle = _active_handle(obj)
        layout.prop_search(handle, "name", obj, "vertex_groups", text="Group")
        status = object_status.last_known(obj)
        count = status.member_counts.get(handle.name) if status else None
        if count is not None:
            layout.label(text=wording.vertices(count))
        layout.prop(handle, "follows")
        if handle.follows == 'CONTROL':
            layout.prop(handle, "control")
            if handle.control is not None and handle.control.type == 'ARMATURE':
                layout.prop_search(handle, "bone", handle.control.pose, "bones")
            problem = controls.problem(obj, handle)
            if problem:
                draw_wrapped(layout, context, wording.sentence(problem), icon='ERROR')
                layout.operator(MEANVALUE_OT_own_controls.bl_idname)
        layout.prop(handle, "is_soft")
        strength = layout.row()
        strength.active = handle.is_soft
        strength.prop(handle, "strength")


class MEANVALUE_PT_region(PanelPart, bpy.types.Panel):
    """Which part of the mesh may move"""

    bl_label = "Region"

    def draw(self, context):
        settings = subject.of(context).meanvalue
        row = self.layout.row(align=True)
        row.prop_search(settings, "roi_group", subject.of(context), "vertex_groups", text="")
        row.prop(settings, "roi_invert", text="", icon='ARROW_LEFTRIGHT')
        buttons = self.layout.column(align=True)
        buttons.operator(MEANVALUE_OT_grow_region.bl_idname, icon='EMPTY_AXIS')
        if subject.of(context).mode == 'WEIGHT_PAINT':
            buttons.operator(MEANVALUE_OT_finish_region.bl_idname, icon='CHECKMARK')
        else:
            buttons.operator(MEANVALUE_OT_paint_region.bl_idname, icon='BRUSH_DATA')


class MEANVALUE_PT_advanced(PanelPart, bpy.types.Panel):
    """What everyday posing does without"""

    bl_idname = "MEANVALUE_PT_advanced"
    bl_label = "Advanced"
    bl_options = {'DEFAULT_CLOSED'}
    bl_order = 100

    def draw(self, context):
        layout = self.layout
        layout.prop(subject.of(context).meanvalue, "result_key", icon='SHAPEKEY_DATA')
        row = layout.row(align=True)
        row.operator(MEANVALUE_OT_bind.bl_idname)
        row.operator(MEANVALUE_OT_unbind.bl_idname)
        solve = layout.column()
        solve.scale_y = 1.4
        solve.operator(MEANVALUE_OT_solve.bl_idname)
        solve.operator(MEANVALUE_OT_solve_from_key.bl_idname)
        layout.operator(MEANVALUE_OT_copy_system_info.bl_idname, icon='COPYDOWN')


class MEANVALUE_PT_solver(PanelPart, bpy.types.Panel):
    """How the shape is found"""

    bl_label = "Solver"
    bl_parent_id = "MEANVALUE_PT_advanced"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = subject.of(context).meanvalue
        layout.prop(settings, "method")
        rigidity = layout.row()
        rigidity.active = settings.method == ids.METHOD_FAST
        rigidity.prop(settings, "rigidity")
        layout.prop(settings, "loose_parts")
        layout.prop(settings, "merge_distance")
        layout.operator_menu_enum(MEANVALUE_OT_select_problems.bl_idname, "kind", icon='RESTRICT_SELECT_OFF')


def _active_handle(obj):
    settings = obj.meanvalue
    if settings.active_handle < len(settings.handles):
        return settings.handles[settings.active_handle]
    return None


def _draw_live(layout, obj):
    row = layout.row()
    row.scale_y = 1.4
    row.prop(obj.meanvalue, "live", toggle=True, icon='PLAY')
    row.prop(obj.meanvalue, "show_overlay", text="", toggle=True, icon='OVERLAY')
    split = layout.split(factor=0.4)
    split.label(text="Symmetric")
    row = split.row(align=True)
    row.prop_enum(obj.meanvalue, "symmetric", 'NONE')
    axes = row.row(align=True)
    axes.scale_x = 0.5
    for axis in ('X', 'Y', 'Z'):
        axes.prop_enum(obj.meanvalue, "symmetric", axis)


def _draw_handles(layout, obj):
    settings = obj.meanvalue
    layout.operator("wm.tool_set_by_id", text="Grab Tool", icon='VIEW_PAN').name = MEANVALUE_OT_grab.bl_idname
    row = layout.row(align=True)
    row.operator(MEANVALUE_OT_add_handle.bl_idname, icon='EMPTY_AXIS')
    row.operator(MEANVALUE_OT_add_pin.bl_idname, icon='PINNED')
    row = layout.row()
    row.template_list(MEANVALUE_UL_handles.__name__, "", settings, "handles", settings, "active_handle", rows=3)
    buttons = row.column(align=True)
    buttons.operator(MEANVALUE_OT_remove_handle.bl_idname, icon='REMOVE', text="")
    row = layout.row(align=True)
    row.operator(MEANVALUE_OT_reset_handles.bl_idname, icon='LOOP_BACK', text="Reset")
    row.operator(MEANVALUE_OT_keyframe_handles.bl_idname, icon='KEY_HLT', text="Keyframe")
    row = layout.row(align=True)
    row.operator(MEANVALUE_OT_keep_pose.bl_idname, icon='SHAPEKEY_DATA')
    row.operator(MEANVALUE_OT_apply_pose.bl_idname, icon='MESH_DATA', text="As Rest")
    layout.operator(MEANVALUE_OT_finish.bl_idname, icon='CHECKMARK')


def _draw_status(layout, context, obj, status):
    """One thing at a time: what live posing waits for, or what there is to do, with the button that does it."""
    if not obj.meanvalue.handles and not obj.meanvalue.live:
        if not engine.kinds_on(obj):
            hint = (
                "Choose the Grab tool, press on the mesh and drag. Or select vertices in Edit Mode and press "
                "Add Handle."
            )
            draw_wrapped(layout.box(), context, hint, icon='INFO')
        return
    box = layout.box()
    live = engine.status(obj)
    if live:
        text, is_problem = live
        draw_wrapped(box, context, text, icon='ERROR' if is_problem else 'PLAY')
    if live is None or status.state is State.BOUND:
        draw_wrapped(box, context, status.text, icon=STATE_ICONS[status.state])
    if status.state is State.STALE or (status.state is State.UNBOUND and live is None):
        box.operator(MEANVALUE_OT_bind.bl_idname)
    if live:
        return
    hint = shape_keys.result_problem(obj)
    if status.state is not State.PROBLEM:
        hint = subject.mode_problem(obj) or hint
    if hint is None and status.state in {State.BOUND, State.STALE}:
        hint = targets.problem(obj)
    if hint:
        draw_wrapped(box, context, wording.sentence(hint), icon='INFO')
    solved = bound_record.read_solve(obj.meanvalue.bound)
    if solved:
        draw_wrapped(box, context, f"Solved: {solved.text()}", icon='SHAPEKEY_DATA')


CLASSES = (
    MEANVALUE_PT_panel,
    MEANVALUE_PT_active_handle,
    MEANVALUE_PT_region,
    MEANVALUE_PT_advanced,
    MEANVALUE_PT_solver,
)
