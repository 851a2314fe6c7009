# SPDX-License-Identifier: GPL-3.0-or-later
"""Registers every class, in order, and takes all of it back."""

import bpy

from . import handlers, preferences, properties
from .baking import panel as bake_panel
from .baking.operators import bake, show_baked_frame, unbake
from .capture import file_drop, marker_list
from .capture import panel as capture_panel
from .capture.bridge import mended_takes
from .capture.operators import (
    find_marker_problems,
    import_motion,
    match_markers,
    pick_marker_point,
    reference_frame,
    remove_marker,
    save_marker_set,
    select_marker,
    swap_markers,
)
from .mixing import mix_session
from .mixing import panel as mix_panel
from .mixing.operators import bake_mix, morph, remove_in_betweens
from .posing.bridge import object_status, overlay_data
from .posing.operators import (
    add_anchor_group,
    add_handle,
    add_pose_key,
    apply_pose,
    bind,
    copy_system_info,
    finish,
    grab,
    grow_region,
    keep_pose,
    keyframe_handles,
    own_controls,
    paint_region,
    pin_here,
    remove_handle,
    reset_handles,
    select_handle,
    select_problems,
    select_unpaired,
    solve,
    toggle_live,
    unbind,
)
from .posing.ui import grab_tool, handle_list, keymap, menus, overlay, panel, symmetry_panel
from .scene import object_model
from .solver import job, native_loader, session
from .widgets import background, pair_overlay
from .wrapping import panel as wrap_panel
from .wrapping.operators import clear_wrap_pairs, pick_wrap_pairs, wrap

CLASSES = (
    preferences.MEANVALUE_AP_preferences,
    add_anchor_group.MEANVALUE_OT_add_anchor_group,
    grab.MEANVALUE_OT_grab,
    pin_here.MEANVALUE_OT_pin_here,
    add_handle.MEANVALUE_OT_add_handle,
    add_handle.MEANVALUE_OT_add_pin,
    remove_handle.MEANVALUE_OT_remove_handle,
    select_handle.MEANVALUE_OT_select_handle,
    reset_handles.MEANVALUE_OT_reset_handles,
    select_problems.MEANVALUE_OT_select_problems,
    select_unpaired.MEANVALUE_OT_select_unpaired,
    own_controls.MEANVALUE_OT_own_controls,
    keep_pose.MEANVALUE_OT_keep_pose,
    keyframe_handles.MEANVALUE_OT_keyframe_handles,
    finish.MEANVALUE_OT_finish,
    apply_pose.MEANVALUE_OT_apply_pose,
    add_pose_key.MEANVALUE_OT_add_pose_key,
    bind.MEANVALUE_OT_bind,
    unbind.MEANVALUE_OT_unbind,
    solve.MEANVALUE_OT_solve,
    toggle_live.MEANVALUE_OT_toggle_live,
    grow_region.MEANVALUE_OT_grow_region,
    paint_region.MEANVALUE_OT_paint_region,
    paint_region.MEANVALUE_OT_finish_region,
    bake.MEANVALUE_OT_bake,
    show_baked_frame.MEANVALUE_OT_show_baked_frame,
    unbake.MEANVALUE_OT_unbake,
    morph.MEANVALUE_OT_morph,
    morph.MEANVALUE_OT_blend_part,
    pick_wrap_pairs.MEANVALUE_OT_pick_wrap_pairs,
    clear_wrap_pairs.MEANVALUE_OT_clear_wrap_pairs,
    wrap.MEANVALUE_OT_wrap,
    bake_mix.MEANVALUE_OT_bake_mix,
    remove_in_betweens.MEANVALUE_OT_remove_in_betweens,
    copy_system_info.MEANVALUE_OT_copy_system_info,
    import_motion.MEANVALUE_OT_import_motion,
    find_marker_problems.MEANVALUE_OT_find_marker_problems,
    find_marker_problems.MEANVALUE_OT_show_marker_problem,
    swap_markers.MEANVALUE_OT_swap_markers,
    reference_frame.MEANVALUE_OT_set_reference_frame,
    match_markers.MEANVALUE_OT_match_markers,
    select_marker.MEANVALUE_OT_select_marker,
    pick_marker_point.MEANVALUE_OT_pick_marker_point,
    remove_marker.MEANVALUE_OT_remove_marker,
    save_marker_set.MEANVALUE_OT_save_marker_set,
    *marker_list.CLASSES,
    handle_list.MEANVALUE_UL_handles,
    *panel.CLASSES,
    *symmetry_panel.CLASSES,
    *capture_panel.CLASSES,
    *file_drop.CLASSES,
    *mix_panel.CLASSES,
    *wrap_panel.CLASSES,
    *bake_panel.CLASSES,
    *menus.CLASSES,
)

#: What is hung into Blender's own user interface.
USER_INTERFACE = (menus, keymap, grab_tool, overlay, pair_overlay)


def register():
    native_loader.forget()
    properties.register()
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    handlers.register()
    for module in USER_INTERFACE:
        module.register()


def unregister():
    background.end_all()
    grab.end_all()
    for module in reversed(USER_INTERFACE):
        module.unregister()
    handlers.unregister()
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
    properties.unregister()
    job.cancel_all()
    object_model.clear()
    object_status.clear()
    overlay_data.clear()
    mended_takes.forget()
    session.clear()
    mix_session.clear()
