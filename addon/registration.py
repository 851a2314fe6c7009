# SPDX-License-Identifier: GPL-3.0-or-later
"""Registers the rooms, in order, their pages of the guide and the add-on's preferences, and takes all of it back. Each
room says what of its own is kept on an object (`object.meanvalue`) and on a collection (`collection.meanvalue`)."""

import importlib
import pathlib

import bpy
from bpy.props import PointerProperty

from . import handlers, ids, rooms, wording
from .scene import object_model
from .scene.baked import MEANVALUE_PG_baked
from .scene.declarations import aside
from .solver import job, native_loader, session
from .widgets import base, overlay, panels

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

#: The guide, put here when the add-on is packaged, and where it begins.
FOLDER = pathlib.Path(__file__).resolve().parent / "manual"
START = (FOLDER / "index.html").as_uri()


def meanvalue_manual_map():
    """Online Manual (F1) over what is ours opens its page of the guide, which comes with the add-on, in the browser."""
    return f"{FOLDER.as_uri()}/guide/", tuple(_entries())


def _entries():
    """(pattern in lower case, page)"""
    for room in ROOMS:
        for cls in room.classes:
            if issubclass(cls, bpy.types.Operator):
                yield f"bpy.ops.{cls.bl_idname}*", f"{room.pages.get(cls.bl_idname, room.page)}.html"
            elif issubclass(cls, bpy.types.PropertyGroup):
                yield f"bpy.types.{cls.__name__.lower()}.*", f"{room.page}.html"
        for name in room.settings:
            yield f"bpy.types.meanvalue_pg_settings.{name}", f"{room.page}.html"


class MEANVALUE_AP_preferences(bpy.types.AddonPreferences):  # noqa: N801  Blender's way
    bl_idname = __package__

    def draw(self, context):
        box = self.layout.box()
        box.label(text="Solver")
        problem = native_loader.problem()
        if problem:
            panels.draw_wrapped(box, context, wording.sentence(problem), icon='ERROR')
        else:
            ready = f"Ready, version {native_loader.module().__version__}"
            box.label(text=ready, icon='CHECKMARK')
        row = self.layout.row()
        row.operator("wm.url_open", text="Documentation", icon='HELP').url = START
        row.operator("meanvalue.copy_system_info", text="Copy System Info for a Bug Report", icon='URL')


class MEANVALUE_PG_settings(bpy.types.PropertyGroup):  # noqa: N801
    """Settings of Mean-Value Deform for one object"""

    __annotations__ = {"baked": aside(PointerProperty)(type=MEANVALUE_PG_baked)}
    __annotations__.update({name: setting for room in ROOMS for name, setting in room.settings.items()})


_classes = [MEANVALUE_PG_baked, *(each for room in ROOMS for each in room.classes), MEANVALUE_PG_settings]
#: Groups of settings first, each behind those that it has.
CLASSES = sorted([*_classes, MEANVALUE_AP_preferences], key=lambda each: not issubclass(each, bpy.types.PropertyGroup))

#: What has settings, and which.
OWNERS = {bpy.types.Object: MEANVALUE_PG_settings}
for _kind in filter(None, (room.of_collections for room in ROOMS)):
    OWNERS[bpy.types.Collection] = _kind

#: A class that every copy of the add-on registers, and the module that has it: they tell whether another copy is on.
MARK, MARK_MODULE = "MEANVALUE_PT_panel", ".posing.ui.panel"


def register():
    mark = getattr(bpy.types, MARK, None)
    package = mark.__module__.removesuffix(MARK_MODULE) if mark else __package__
    if package != __package__:
        raise RuntimeError(f"Another copy of Mean-Value Deform is on ({package}). Untick it, then tick this one")
    native_loader.forget()
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    for owner, kind in OWNERS.items():
        setattr(owner, ids.OBJECT_PROPERTY, PointerProperty(type=kind))
    rooms.take_in(ROOMS)
    handlers.register()
    for menu, draw in rooms.ALL.blender_menus:
        menu.append(draw)
    for room in ROOMS:
        room.register()
    overlay.register()
    bpy.utils.register_manual_map(meanvalue_manual_map)


def unregister():
    base.end_all()
    bpy.utils.unregister_manual_map(meanvalue_manual_map)
    overlay.unregister()
    for room in reversed(ROOMS):
        room.unregister()
    for menu, draw in rooms.ALL.blender_menus:
        menu.remove(draw)
    handlers.unregister()
    rooms.take_in(())
    for owner in OWNERS:
        delattr(owner, ids.OBJECT_PROPERTY)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
    job.cancel_all()
    object_model.clear()
    session.cache.clear()
