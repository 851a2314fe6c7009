# SPDX-License-Identifier: GPL-3.0-or-later
"""Registers the rooms, in order, and takes all of it back."""

import importlib

import bpy

from . import handlers, manual, properties, rooms
from .scene import object_model
from .solver import job, native_loader, session
from .widgets import base, overlay

#: Each is a folder with a room.py. Deleting the folder and the line here takes the room out.
ROOMS = tuple(
    importlib.import_module(f"{__package__}.{name}.room").ROOM
    for name in (
        "posing",
        "capture",
        "mixing",
        "wrapping",
        "baking",
        "sliders",
    )
)

#: But for groups of settings, see properties.py.
CLASSES = [manual.MEANVALUE_AP_preferences, *(each for room in ROOMS for each in room.classes)]
CLASSES = [each for each in CLASSES if not issubclass(each, bpy.types.PropertyGroup)]

#: A class that every copy of the add-on registers, and the module that has it: they tell whether another copy is on.
MARK, MARK_MODULE = "MEANVALUE_PT_panel", ".posing.ui.panel"


def register():
    mark = getattr(bpy.types, MARK, None)
    package = mark.__module__.removesuffix(MARK_MODULE) if mark else __package__
    if package != __package__:
        raise RuntimeError(f"Another copy of Mean-Value Deform is on ({package}). Untick it, then tick this one")
    native_loader.forget()
    properties.register(ROOMS)
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    rooms.take_in(ROOMS)
    handlers.register()
    for menu, draw in rooms.ALL.blender_menus:
        menu.append(draw)
    for room in ROOMS:
        room.register()
    overlay.register()
    manual.register(ROOMS)


def unregister():
    base.end_all()
    manual.unregister()
    overlay.unregister()
    for room in reversed(ROOMS):
        room.unregister()
    for menu, draw in rooms.ALL.blender_menus:
        menu.remove(draw)
    handlers.unregister()
    rooms.take_in(())
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
    properties.unregister(ROOMS)
    job.cancel_all()
    object_model.clear()
    session.cache.clear()
