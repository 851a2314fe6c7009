# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidebar panel."""

import bpy

from .. import ids, native_loader
from ..bridge import bound_record, object_status, scene_input, shape_keys
from ..bridge.object_status import State
from ..core import wording
from ..operators.add_anchor_group import MEANVALUE_OT_add_anchor_group
from ..operators.add_pose_key import MEANVALUE_OT_add_pose_key
from ..operators.bind import MEANVALUE_OT_bind
from ..operators.remove_anchor_group import MEANVALUE_OT_remove_anchor_group
from ..operators.solve import MEANVALUE_OT_solve
from ..operators.unbind import MEANVALUE_OT_unbind
from .anchor_list import MEANVALUE_UL_anchor_groups
from .text_box import draw_wrapped

STATE_ICONS = {
    State.UNBOUND: 'RADIOBUT_OFF',
    State.BOUND: 'CHECKMARK',
    State.STALE: 'FILE_REFRESH',
    State.PROBLEM: 'ERROR',
}


class MEANVALUE_PT_panel(bpy.types.Panel):
    """Pose the active mesh by its anchors"""

    bl_idname = "MEANVALUE_PT_panel"
    bl_label = "Mean-Value"
    bl_space_type = 'VIEW_3D'
    bl_region_type = 'UI'
    bl_category = ids.SIDEBAR_TAB

    def draw(self, context):
        layout = self.layout
        obj = context.object
        problem = native_loader.problem()
        if problem:
            draw_wrapped(layout.box(), context, wording.sentence(problem), icon='ERROR')
        problem = scene_input.object_problem(obj)
        if problem:
            draw_wrapped(layout, context, wording.sentence(problem), icon='INFO')
            return
        status = object_status.status(obj, object_status.QUIET_SECONDS)
        _draw_anchors(layout, obj)
        _draw_region(layout, obj)
        _draw_actions(layout, context, obj)
        _draw_status(layout, context, obj, status)


def _draw_anchors(layout, obj):
    settings = obj.meanvalue
    layout.label(text="Anchors")
    row = layout.row()
    row.template_list(
        MEANVALUE_UL_anchor_groups.__name__, "", settings, "anchor_groups", settings, "active_anchor_group", rows=3
    )
    buttons = row.column(align=True)
    buttons.operator(MEANVALUE_OT_add_anchor_group.bl_idname, icon='ADD', text="")
    buttons.operator(MEANVALUE_OT_remove_anchor_group.bl_idname, icon='REMOVE', text="")
    if settings.active_anchor_group < len(settings.anchor_groups):
        active = settings.anchor_groups[settings.active_anchor_group]
        layout.prop_search(active, "name", obj, "vertex_groups", text="Group")


def _draw_region(layout, obj):
    settings = obj.meanvalue
    row = layout.row(align=True)
    row.prop_search(settings, "roi_group", obj, "vertex_groups", text="Region")
    row.prop(settings, "roi_invert", text="", icon='ARROW_LEFTRIGHT')


def _draw_actions(layout, context, obj):
    row = layout.row(align=True)
    row.operator(MEANVALUE_OT_bind.bl_idname)
    row.operator(MEANVALUE_OT_unbind.bl_idname)
    layout.operator(MEANVALUE_OT_add_pose_key.bl_idname, icon='SHAPEKEY_DATA')
    layout.prop(obj.meanvalue, "result_key", icon='SHAPEKEY_DATA')
    solve = layout.column()
    solve.scale_y = 1.4
    solve.operator(MEANVALUE_OT_solve.bl_idname)


def _draw_status(layout, context, obj, status):
    box = layout.box()
    draw_wrapped(box, context, status.text, icon=STATE_ICONS[status.state])
    hint = scene_input.mode_problem(obj) or shape_keys.result_problem(obj)
    if hint is None and status.state in {State.BOUND, State.STALE}:
        hint = shape_keys.pose_problem(obj)
    if hint:
        draw_wrapped(box, context, wording.sentence(hint), icon='INFO')
    solved = bound_record.read_solve(obj.meanvalue.bound)
    if solved:
        draw_wrapped(box, context, f"Solved: {solved.text()}", icon='SHAPEKEY_DATA')
