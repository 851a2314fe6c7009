# SPDX-License-Identifier: GPL-3.0-or-later
"""Registers every class, in order, and takes all of it back."""

import bpy

from . import handlers, native_loader, preferences, properties, session
from .bridge import object_status
from .operators import (
    add_anchor_group,
    add_pose_key,
    bind,
    remove_anchor_group,
    solve,
    unbind,
)
from .ui import anchor_list, panel

CLASSES = (
    preferences.MEANVALUE_AP_preferences,
    add_anchor_group.MEANVALUE_OT_add_anchor_group,
    remove_anchor_group.MEANVALUE_OT_remove_anchor_group,
    add_pose_key.MEANVALUE_OT_add_pose_key,
    bind.MEANVALUE_OT_bind,
    unbind.MEANVALUE_OT_unbind,
    solve.MEANVALUE_OT_solve,
    anchor_list.MEANVALUE_UL_anchor_groups,
    panel.MEANVALUE_PT_panel,
)


def register():
    native_loader.forget()
    properties.register()
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    handlers.register()


def unregister():
    handlers.unregister()
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
    properties.unregister()
    object_status.clear()
    session.clear()
