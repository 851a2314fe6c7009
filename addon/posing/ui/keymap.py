# SPDX-License-Identifier: GPL-3.0-or-later
"""Keyboard shortcuts. They are free in Blender's own keymap, and can be changed in Preferences > Keymap.

Blender keeps what the artist changed beside what is registered here, so that it survives.
"""

import bpy

from ...scene import subject

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


def register():
    setattr(bpy.types.Scene, LIVE, bpy.props.BoolProperty(name="Live", get=_is_live, set=_turn_live))
    keyconfig = bpy.context.window_manager.keyconfigs.addon
    if keyconfig is None:  # in the background
        return
    for name, operator, properties, key, modifiers in SHORTCUTS:
        keymap = keyconfig.keymaps.new(name=name)
        item = keymap.keymap_items.new(operator, key, 'PRESS', **modifiers)
        _made.append((keymap, item))
        for each, value in properties.items():
            setattr(item.properties, each, value)


def unregister():
    delattr(bpy.types.Scene, LIVE)
    while _made:
        keymap, item = _made.pop()
        keymap.keymap_items.remove(item)
