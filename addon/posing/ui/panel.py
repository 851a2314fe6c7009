# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidebar panel, its parts, and the lists of handles and pins, and of objects that go along."""

import bpy

from ... import ids, wording
from ...live import engine
from ...rooms import ALL
from ...scene import along, baked, key_marks, mirrors, pose_objects, shape_keys, subject, worn
from ...solver import native_loader
from ...widgets import overlay
from ...widgets.panels import PanelPart, SidebarPanel, column_of_settings, draw_wrapped
from ..bridge import controls, key_poses, members, orphans, scene_input, targets
from ..operators import drive_by_bone, tool_choice
from .menus import MEANVALUE_MT_apply, draw_add

FOLLOWS_ICONS = {'CONTROL': 'EMPTY_AXIS', 'REST': 'PINNED'}
HINT = "Press on the mesh and drag. Shift-click holds a place. The wheel says how much follows."
NEXT_HINT = "Press elsewhere for another handle, Shift-click for a pin. R turns the selected control, X removes it."


class MEANVALUE_UL_handles(bpy.types.UIList):
    """One line for each handle or pin: on or off, color, name, and a button to select it"""

    def draw_item(self, context, layout, _data, item, _icon, _active_data, _active_property, index):
        obj = subject.of(context)
        row = layout.row(align=True)
        row.prop(item, "is_enabled", text="")
        color = row.row(align=True)
        color.ui_units_x = 0.6
        color.prop(item, "color", text="")
        broken = members.is_missing(obj, item) or controls.problem(obj, item) is not None
        name = row.row()
        name.alert = broken
        name.active = item.is_enabled
        icon = 'ERROR' if broken else FOLLOWS_ICONS[item.follows]
        name.label(text=item.name, icon=icon, translate=False)
        row.operator("meanvalue.select_handle", text="", icon='RESTRICT_SELECT_OFF').index = index

    def filter_items(self, _context, data, collection):
        """Without the handles whose control was deleted."""
        handles = getattr(data, collection)
        shown = bpy.types.UI_UL_list.filter_items_by_name(self.filter_name, self.bitflag_filter_item, handles)
        shown = shown or [self.bitflag_filter_item] * len(handles)
        return [0 if orphans.is_deleted(handle) else flag for handle, flag in zip(handles, shown, strict=True)], []


class MEANVALUE_UL_kept_poses(bpy.types.UIList):
    """One line for each kept pose: name and slider"""

    def draw_item(self, _context, layout, _data, item, _icon, _active_data, _active_property, _index):
        row = layout.row(align=True)
        row.prop(item, "name", text="", emboss=False)
        row.prop(item, "value", text="", slider=True, emboss=False)
        if key_poses.off_by(item) > key_poses.OFF:
            row.label(text=f"{key_poses.off_by(item):.1%} off")
        if key_poses.pose_of(item):
            button = row.operator("meanvalue.drive_by_bone", text="", icon='POSE_HLT', emboss=False)
            button.does, button.key = 'POSE', item.name

    def filter_items(self, _context, data, collection):
        kept = {key.name for key in key_marks.of_role(data, key_marks.Role.KEPT)}
        return [self.bitflag_filter_item * (key.name in kept) for key in getattr(data, collection)], []


class MEANVALUE_PT_panel(SidebarPanel, bpy.types.Panel):
    """Pose the mesh by handles: what holds it, and whether it follows"""

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
            if pose_objects.is_foreign(obj):
                _draw_grab(layout, context, obj)
            return
        if overlay.problem:
            draw_wrapped(layout, context, wording.sentence(overlay.problem), icon='ERROR')
        carrier = worn.carrier(obj)
        if carrier is not None:
            name = pose_objects.shown(carrier).name
            text = f"'{pose_objects.shown(obj).name}' goes along with '{name}'. Press on it with Grab to pose '{name}'"
            draw_wrapped(layout, context, wording.sentence(text), icon='INFO')
        if any(draw_top(layout, context, obj) for draw_top in ALL.tops):
            return
        is_posed = obj.meanvalue.handles or shape_keys.result(obj) or pose_objects.shown(obj) != obj
        is_new = carrier is not None or not is_posed
        if is_new and carrier is None:
            draw_wrapped(layout, context, HINT, icon='INFO')
        _draw_grab(layout, context, obj)
        if obj.mode == 'EDIT':
            draw_add(layout.column(align=True))
        if not is_new:
            settings, row = obj.meanvalue, layout.row()
            name, lines = MEANVALUE_UL_handles.__name__, {"rows": 4, "maxrows": 4}  # buttons below stay where they are
            row.template_list(name, "", settings, "handles", settings, "active_handle", **lines)
            buttons = row.column(align=True)
            buttons.operator("meanvalue.remove_handle", icon='REMOVE', text="")
            buttons.prop(settings, "show_overlay", text="", toggle=True, icon='OVERLAY')
            layout.prop(settings, "live", toggle=True, icon='PLAY')
            row = layout.row(align=True)
            row.operator("meanvalue.reset_handles", icon='LOOP_BACK', text="Reset")
            row.operator("meanvalue.keyframe_handles", icon='KEY_HLT', text="Keyframe")
            row = layout.row(align=True)
            row.operator("meanvalue.keep_pose", icon='SHAPEKEY_DATA')
            row.menu(MEANVALUE_MT_apply.__name__, icon='CHECKMARK')
            keys = obj.data.shape_keys
            if keys is not None and key_marks.of_role(keys, key_marks.Role.KEPT):
                name, column = MEANVALUE_UL_kept_poses.__name__, layout.column(align=True)
                column.template_list(name, "", keys, "key_blocks", obj, "active_shape_key_index", rows=2, maxrows=2)
                row = column.row(align=True)
                row.operator("meanvalue.drive_by_bone", icon='DRIVER')
                if obj.active_shape_key is not None and drive_by_bone.is_driven(obj.active_shape_key):
                    row.operator("meanvalue.drive_by_bone", text="", icon='X').remove = True
                row.operator_menu_enum("meanvalue.drive_by_bone", "does", text="", icon='DOWNARROW_HLT')
        if len(obj.meanvalue.handles) == 1:  # below all else, so that nothing moves under the mouse when it goes
            draw_wrapped(layout, context, NEXT_HINT, icon='INFO')
        found = _status(obj)  # one thing at a time, only what is wrong, slow or to be decided, with what does it
        if found is not None:
            draw_wrapped(layout, context, wording.sentence(found[0]), icon='ERROR' if found[1] else 'INFO')
            if found[2]:
                layout.operator("meanvalue.bind", icon='FILE_REFRESH')


class PosingPart(PanelPart):
    """Mix-in: not while a bake plays in place of the pose."""

    @classmethod
    def poll(cls, context):
        return super().poll(context) and not subject.of(context).meanvalue.baked.target


class MEANVALUE_PT_active_handle(PosingPart, bpy.types.Panel):
    """What the active handle holds and follows"""

    bl_label = "Active Handle"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and controls.none_active(subject.of(context)) is None

    def draw(self, context):
        layout = column_of_settings(self.layout)
        obj = subject.of(context)
        handle = obj.meanvalue.handles[obj.meanvalue.active_handle]
        if handle.mark:
            layout.prop(handle, "name")
        else:
            layout.prop_search(handle, "name", obj, "vertex_groups", text="Group")
        count = scene_input.member_count(obj, obj.meanvalue.active_handle)
        layout.label(text="" if count is None else wording.vertices(count))
        layout.prop(handle, "follows")
        if handle.follows == 'CONTROL':
            layout.prop(handle, "control")
            if handle.control is not None and handle.control.type == 'ARMATURE':
                layout.prop_search(handle, "bone", handle.control.pose, "bones")
            problem = controls.problem(obj, handle)
            if problem:
                draw_wrapped(layout, context, wording.sentence(problem), icon='ERROR')
                layout.operator("meanvalue.bind", icon='FILE_REFRESH')
        layout.prop(handle, "is_soft")
        strength = layout.row()
        strength.active = handle.is_soft
        strength.prop(handle, "strength")


class MEANVALUE_PT_region(PosingPart, bpy.types.Panel):
    """Which part of the mesh may move"""

    bl_label = "Region"

    def draw(self, context):
        obj = subject.of(context)
        self.layout.prop_search(obj.meanvalue, "roi_group", obj, "vertex_groups", text="")
        buttons = self.layout.column(align=True)
        buttons.operator("meanvalue.grow_region", icon='EMPTY_AXIS')
        buttons.operator("meanvalue.paint_region", icon='BRUSH_DATA', depress=obj.mode == 'WEIGHT_PAINT')


class MEANVALUE_PT_advanced(PanelPart, bpy.types.Panel):
    """What everyday posing does without"""

    bl_label = "Advanced"
    bl_order = 100

    def draw(self, context):
        layout = column_of_settings(self.layout)
        settings = subject.of(context).meanvalue
        layout.prop(settings, "method")
        rigidity = layout.column()
        rigidity.active = settings.method == ids.METHOD_FAST
        rigidity.prop(settings, "rigidity")
        bend = rigidity.row(align=True)
        bend.prop(settings, "bend_at")
        bend.prop(settings, "show_joints", text="", icon='HIDE_OFF' if settings.show_joints else 'HIDE_ON')
        if settings.bend_at == ids.BEND_RIG:
            rigidity.prop(settings, "stretch")
        if settings.bend_at == ids.BEND_PAINTED:
            rigidity.prop_search(settings, "stiffness_group", subject.of(context), "vertex_groups")
        like = layout.row()
        like.active = not any(each.names(subject.of(context)) for each in ALL.shown_keys)
        like.prop(settings, "pose_like")
        if settings.pose_like == ids.LIKE_RIG:
            layout.operator("meanvalue.sample_rig_poses", icon='ARMATURE_DATA')
        layout.prop(settings, "loose_parts")
        layout.prop(settings, "close_seams")
        layout.prop(settings, "merge_distance")
        known = scene_input.known(subject.of(context))
        if known is not None and known.joined_places:
            layout.label(text=f"{wording.counted(known.joined_places, 'place')} joined")
        layout.prop(settings, "result_key")
        solve = layout.column(align=True)
        solve.operator("meanvalue.bind")
        solve.operator("meanvalue.solve_from_key")
        layout.operator_menu_enum("meanvalue.select_problems", "kind", icon='RESTRICT_SELECT_OFF')


def _draw_grab(layout, context, obj):
    grab = layout.row()
    grab.scale_y = 1.6
    is_active = tool_choice.is_active(context)
    button = grab.operator("meanvalue.grab", text="Grab", icon='VIEW_PAN', depress=is_active)
    button.choose_tool = True
    if pose_objects.is_foreign(obj):
        return
    column = column_of_settings(layout)
    tool = tool_choice.settings(context)
    if tool is not None:
        column.prop(tool, "size")
    column.prop(obj.meanvalue, "symmetric")
    known = scene_input.known(obj)
    if known is not None and known.bends:
        draw_wrapped(column, context, known.bends)


def _status(obj):
    """(text, whether it is a problem, whether Update mends it), or None if all is well."""
    if not obj.meanvalue.handles:
        return None
    found = scene_input.fit_problem(obj)
    wants_update = (found is not None and found[1]) or any(
        handle.follows == 'CONTROL' and controls.why_it_is_missing(obj, handle) for handle in obj.meanvalue.handles
    )
    live = engine.status(obj)
    if live is not None:
        return *live, wants_update and live[1]
    problem = found[0] if found is not None else targets.problem(obj)
    if problem:
        return problem, True, wants_update
    notes = mirrors.notes(obj)
    return (notes[0], False, False) if notes else None


class MEANVALUE_UL_along(bpy.types.UIList):
    """One line for each object: whether it goes along, and how"""

    def draw_item(self, context, layout, _data, item, _icon, _active_data, _active_property, _index):
        alone, row = worn.problem(subject.of(context), item.object), layout.row(align=True)
        row.prop(item, "is_taken", text="")
        name = row.row()
        name.active = item.is_taken and not alone
        name.label(text=item.object.name, icon='ERROR' if alone else 'MESH_DATA', translate=False)
        row.prop(item, "kind", text="", emboss=False)

    def filter_items(self, context, data, collection):
        there = [other for _, other in worn.listed(subject.of(context))]
        return [self.bitflag_filter_item * (line.object in there) for line in getattr(data, collection)], []


class MEANVALUE_PT_along(PosingPart, bpy.types.Panel):
    """Which objects go along when the mesh is posed: clothes, hair, eyes"""

    bl_label = "Takes Along"

    @classmethod
    def poll(cls, context):
        is_alone = len(bpy.data.meshes) == 1  # the tab is long
        return super().poll(context) and not is_alone and worn.carrier(subject.of(context)) is None

    def draw_header_preset(self, context):
        count, alone = len(worn.taken(subject.of(context))), len(along.problems(subject.of(context)))
        text = f"{count} of {count + alone}" if alone else wording.counted(count, "object") if count else ""
        self.layout.label(text=text)

    def draw(self, context):
        layout, obj = self.layout, subject.of(context)
        settings, notes, name = obj.meanvalue, along.problems(obj), MEANVALUE_UL_along.__name__
        if settings.along:
            layout.label(text=f"Takes along {wording.counted(len(worn.taken(obj)), 'object')}")
            layout.template_list(name, "", settings, "along", settings, "active_along", rows=3, maxrows=6)
            notes += [f"A mix of shape keys moves '{obj.name}' alone"] if baked.source(obj) else []
        layout.operator("meanvalue.find_along", text="Find", icon='VIEWZOOM')
        for text in notes:
            draw_wrapped(layout, context, wording.sentence(text), icon='INFO')
