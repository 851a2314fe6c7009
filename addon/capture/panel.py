# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion Capture, a part of the sidebar panel: from a file to a mesh that follows it, from top to bottom."""

import bpy

from .. import wording
from ..scene import subject
from ..widgets.panels import SidebarPanel, column_of_settings, draw_main_button, draw_wrapped
from .bridge import marker_pairs, takes
from .operators.match_markers import MEANVALUE_OT_match_markers, MEANVALUE_OT_pick_marker_point
from .operators.take import (
    MEANVALUE_OT_find_marker_problems,
    MEANVALUE_OT_import_motion,
    MEANVALUE_OT_swap_markers,
)


class MEANVALUE_PT_capture(SidebarPanel, bpy.types.Panel):
    """Move the mesh by recorded markers"""

    bl_label = "Motion Capture"
    bl_parent_id = "MEANVALUE_PT_panel"
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        layout, obj = self.layout, subject.of(context)
        if not _is_matched(obj):
            _draw_take(layout, context, obj)
        if _has_take(obj):
            matched = f" ({len(marker_pairs.matched(obj))} of {len(obj.meanvalue.capture.pairs)})"
            draw_main_button(layout, MEANVALUE_OT_match_markers, 'SNAP_ON', matched if _is_matched(obj) else "")
            capture, name = obj.meanvalue.capture, MEANVALUE_UL_marker_pairs.__name__
            if capture.pairs:
                layout.template_list(name, "", capture, "pairs", capture, "active_pair", rows=4, maxrows=4)
                buttons = layout.row(align=True)
                buttons.operator(MEANVALUE_OT_pick_marker_point.bl_idname, icon='EYEDROPPER')
                buttons.operator(MEANVALUE_OT_pick_marker_point.bl_idname, text="", icon='REMOVE').remove = True


class MEANVALUE_PT_matching(SidebarPanel, bpy.types.Panel):
    """How markers are laid on the mesh, and what becomes of their gaps; the take too, once they are"""

    bl_label = "Matching"
    bl_parent_id = MEANVALUE_PT_capture.__name__
    bl_options = {'DEFAULT_CLOSED'}

    @classmethod
    def poll(cls, context):
        return _has_take(subject.of(context))

    def draw(self, context):
        layout, capture = self.layout, subject.of(context).meanvalue.capture
        if _is_matched(subject.of(context)):
            _draw_take(layout, context, subject.of(context))
        column = column_of_settings(layout)
        pair = marker_pairs.active_pair(subject.of(context))
        if pair is not None:
            column.prop(pair, "landmark")
        column.prop(capture, "align")
        limbs = column.row()
        limbs.active = capture.align != 'NONE'
        limbs.prop(capture, "pose_limbs")
        column.prop(capture, "mode")
        column.prop(capture, "keep_floor")
        column.prop(capture, "floor_height")
        column.prop(capture, "rigid_seconds")
        smooth = layout.row(align=True)
        smooth.prop(capture, "use_low_pass")
        cutoff = smooth.row()
        cutoff.active = capture.use_low_pass
        cutoff.prop(capture, "cutoff_hz", text="Hz")


def _has_take(obj):
    return subject.object_problem(obj) is None and takes.is_take(obj.meanvalue.capture.take)


def _is_matched(obj):
    return _has_take(obj) and any(handle.marker for handle in obj.meanvalue.handles)


def _draw_take(layout, context, obj):
    layout.operator(MEANVALUE_OT_import_motion.bl_idname, icon='IMPORT')
    if subject.object_problem(obj) is None:
        column_of_settings(layout).prop(obj.meanvalue.capture, "take")
    if _has_take(obj):
        take = obj.meanvalue.capture.take.meanvalue
        missing = f", {wording.share(take.missing_share)} missing" if take.missing_share else ""
        text = f"{wording.counted(take.sample_count, 'sample')} at {take.rate_hz:g} Hz{missing}"
        draw_wrapped(layout, context, text)
    _draw_problems(layout, context)
    if _has_take(obj):
        column = column_of_settings(layout)
        column.prop(obj.meanvalue.capture, "reference_take", text="Reference")
        row = column.row(align=True)
        row.prop(obj.meanvalue.capture, "reference_frame", text="Frame")
        present = row.operator("wm.context_set_value", text="", icon='TIME')
        present.data_path = f"blend_data.objects[{obj.name!r}].meanvalue.capture.reference_frame"
        present.value = "context.scene.frame_current_final"
    elif not any(takes.is_take(collection) for collection in bpy.data.collections):
        draw_wrapped(layout, context, "Import a C3D, TRC or BVH file to begin with", icon='INFO')


def _draw_problems(layout, context):
    take = takes.chosen(context)
    if take is None:
        return
    layout.operator(MEANVALUE_OT_find_marker_problems.bl_idname, icon='VIEWZOOM')
    settings = take.meanvalue
    if not settings.is_searched:
        return
    if not settings.problems:
        layout.label(text="No problems found", icon='CHECKMARK')
        return
    layout.template_list(
        MEANVALUE_UL_marker_problems.__name__, "", settings, "problems", settings, "active_problem", rows=3, maxrows=3
    )
    problem = takes.active_problem(settings)
    if problem is not None:
        draw_wrapped(layout, context, wording.sentence(problem.text))
        if problem.other is not None:
            layout.operator(MEANVALUE_OT_swap_markers.bl_idname, icon='ARROW_LEFTRIGHT')


class MEANVALUE_UL_marker_pairs(bpy.types.UIList):
    """One line for each marker: whether it is used, its name, how far it is from its point; the worst first. A click
    selects its control or Empty"""

    use_filter_sort_reverse = False

    def draw_item(self, context, layout, _data, item, _icon, _active_data, _active_property):
        row = layout.row(align=True)
        row.prop(item, "is_used", text="")
        row = row.split(factor=0.6, align=True)
        name = row.row(align=True)
        name.active = item.is_used and (item.control is not None or item.is_picked)
        name.alignment = 'LEFT'
        name.label(text=item.name, translate=False, icon='EYEDROPPER' if item.is_picked else 'NONE')
        units = context.scene.unit_settings
        far = bpy.utils.units.to_string(units.system, 'LENGTH', item.distance * units.scale_length, precision=2)
        row.label(text=far if item.distance >= 0.0 else "")

    def filter_items(self, _context, data, property_name):
        pairs = getattr(data, property_name)
        flags = bpy.types.UI_UL_list.filter_items_by_name(self.filter_name, self.bitflag_filter_item, pairs)
        if self.use_filter_sort_alpha:
            return flags, bpy.types.UI_UL_list.sort_items_by_name(pairs)
        worst = sorted(range(len(pairs)), key=lambda number: -pairs[number].distance)
        return flags, sorted(range(len(pairs)), key=worst.__getitem__)  # the place of each


class MEANVALUE_UL_marker_problems(bpy.types.UIList):
    """One line for each problem, with its frame; a click goes there"""

    def draw_item(self, _context, layout, _data, item, _icon, _active_data, _active_property):
        split = layout.split(factor=0.2)
        split.label(text=f"{item.frame:.0f}")
        split.label(text=item.text)
