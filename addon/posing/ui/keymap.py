# SPDX-License-Identifier: GPL-3.0-or-later
"""Keyboard shortcuts. They are free in Blender's own keymap, and can be changed in the add-on's preferences.

Blender keeps what the artist changed beside what is registered here, so that it survives.
"""

import bpy

from ..operators.add_handle import MEANVALUE_OT_add_handle, MEANVALUE_OT_add_pin
from ..operators.reset_handles import MEANVALUE_OT_reset_handles
from ..operators.toggle_live import MEANVALUE_OT_toggle_live

#: (keymap, operator, key, modifiers)
SHORTCUTS = (
    ("Object Mode", MEANVALUE_OT_toggle_live.bl_idname, 'L', {"alt": True}),
    ("Object Mode", MEANVALUE_OT_reset_handles.bl_idname, 'L', {"alt": True, "shift": True}),
    ("Mesh", MEANVALUE_OT_add_handle.bl_idname, 'H', {"ctrl": True, "alt": True}),
    ("Mesh", MEANVALUE_OT_add_pin.bl_idname, 'P', {"ctrl": True, "alt": True}),
)


def draw(layout):
    """The shortcuts as the artist has them, to be edited."""
    import rna_keymap_ui

    keyconfig = bpy.context.window_manager.keyconfigs.user
    for keymap_name, operator, _key, _modifiers in SHORTCUTS:
        keymap = keyconfig.keymaps.get(keymap_name) if keyconfig else None
        item = keymap.keymap_items.find_from_operator(operator) if keymap else None
        if item is not None:
            layout.context_pointer_set("keymap", keymap)
            rna_keymap_ui.draw_kmi([], keyconfig, keymap, item, layout, 0)


def register():
    keyconfig = bpy.context.window_manager.keyconfigs.addon
    if keyconfig is None:  # in the background
        return
    for keymap_name, operator, key, modifiers in SHORTCUTS:
        keymap = keyconfig.keymaps.new(name=keymap_name)
        keymap.keymap_items.new(operator, key, 'PRESS', **modifiers)


def unregister():
    keyconfig = bpy.context.window_manager.keyconfigs.addon
    if keyconfig is None:
        return
    for keymap_name, operator, _key, _modifiers in SHORTCUTS:
        keymap = keyconfig.keymaps.get(keymap_name)
        for item in [item for item in keymap.keymap_items if item.idname == operator] if keymap else []:
            keymap.keymap_items.remove(item)
