# SPDX-License-Identifier: GPL-3.0-or-later
"""Registers the rooms, in order, and takes all of it back."""

import importlib

import bpy

from . import handlers, manual, preferences, properties
from .scene import object_model
from .solver import job, native_loader, session
from .widgets import base, overlay

#: Each is a folder with a room.py. Deleting the folder and the line here takes the room out. Its HOOKS are what it adds
#: to lists of the shared rooms and to Blender's menus: (list or menu, item). Its register() and unregister(), if it has
#: them, do the rest.
ROOMS = tuple(
    importlib.import_module(f"{__package__}.{name}.room")
    for name in (
        "posing",
        "capture",
        "mixing",
        "wrapping",
        "baking",
        "sliders",
    )
)

CLASSES = (preferences.MEANVALUE_AP_preferences, *(cls for room in ROOMS for cls in room.CLASSES))

#: A class that every copy of the add-on registers, and the module that has it: they tell whether another copy is on.
MARK, MARK_MODULE = "MEANVALUE_PT_panel", ".posing.ui.panel"


def _require_only_copy():
    """@throws RuntimeError if another copy is on (an extension beside a legacy one): its classes would be replaced."""
    mark = getattr(bpy.types, MARK, None)
    package = mark.__module__.removesuffix(MARK_MODULE) if mark else __package__
    if package != __package__:
        raise RuntimeError(f"Another copy of Mean-Value Deform is on ({package}). Untick it, then tick this one")


def register():
    _require_only_copy()
    native_loader.forget()
    properties.register(ROOMS)
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    handlers.register(ROOMS)
    for room in ROOMS:
        for hooks, item in room.HOOKS:
            hooks.append(item)
        getattr(room, "register", lambda: None)()
    overlay.register()
    manual.register(ROOMS)


def unregister():
    base.end_all()
    manual.unregister()
    overlay.unregister()
    for room in reversed(ROOMS):
        getattr(room, "unregister", lambda: None)()
        for hooks, item in room.HOOKS:
            hooks.remove(item)
    handlers.unregister()
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
    properties.unregister(ROOMS)
    job.cancel_all()
    object_model.clear()
    session.cache.clear()
