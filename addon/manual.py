# SPDX-License-Identifier: GPL-3.0-or-later
"""Online Manual (F1) over what is ours opens its page of the guide, which comes with the add-on, in the browser; the
add-on's entry in Preferences leads there too."""

import pathlib

import bpy

from . import wording
from .solver import native_loader
from .widgets import panels

#: The guide, put here when the add-on is packaged, and where it begins.
FOLDER = pathlib.Path(__file__).resolve().parent / "manual"
START = (FOLDER / "index.html").as_uri()

_map = ()


def meanvalue_manual_map():
    return f"{FOLDER.as_uri()}/guide/", _map


def _entries(rooms):
    """(pattern in lower case, page)"""
    for room in rooms:
        for cls in room.classes:
            if issubclass(cls, bpy.types.Operator):
                yield f"bpy.ops.{cls.bl_idname}*", f"{room.pages.get(cls.bl_idname, room.page)}.html"
            elif issubclass(cls, bpy.types.PropertyGroup):
                yield f"bpy.types.{cls.__name__.lower()}.*", f"{room.page}.html"
        for name in room.settings:
            yield f"bpy.types.meanvalue_pg_settings.{name}", f"{room.page}.html"


def register(rooms):
    global _map
    _map = tuple(_entries(rooms))
    bpy.utils.register_manual_map(meanvalue_manual_map)


def unregister():
    bpy.utils.unregister_manual_map(meanvalue_manual_map)


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
