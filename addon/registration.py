# SPDX-License-Identifier: GPL-3.0-or-later
"""Registers the rooms, in order, their pages of the guide and the add-on's preferences, and takes all of it back. Each
room says what of its own is kept on an object (`object.meanvalue`) and on a collection (`collection.meanvalue`).

And what Blender tells us: that objects were edited or moved, that undo or loading replaced everything. Live posing
follows what moved (live/engine.py); all else only forgets or marks. Blender calls handlers for every frame of every
scene: nothing may be gone through there unless something of ours follows or is shown.
"""

import importlib
import pathlib

import bpy
from bpy.app.handlers import persistent
from bpy.props import PointerProperty

from . import ids, rooms, wording
from .live import engine, roll
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

_is_unknown = True  # what the file has: the add-on may be enabled in any, and nobody tells if undo or loading failed
_last_active = {}  # (scene, view layer): name and mode of its active object when the handler saw it last


def _tell(listeners, *arguments):
    for hear in listeners:
        hear(*arguments)


@persistent
def meanvalue_scene_updated(_scene, depsgraph):
    if depsgraph.mode == 'RENDER':  # on a thread of its own
        return
    _notice_objects(depsgraph)
    _tell(rooms.ALL.scene_updated)
    active = depsgraph.view_layer.objects.active
    state = (active.name, active.mode) if active is not None else None
    layer = depsgraph.scene.name, depsgraph.view_layer.name
    if state != _last_active.get(layer):
        _last_active[layer] = state
        if active is not None:
            _tell(rooms.ALL.chosen, active)
    engine.scene_updated(depsgraph)


@persistent
def meanvalue_frame_changed(_scene, depsgraph):
    if depsgraph.mode == 'RENDER':
        engine.rendered_frame(depsgraph)
        return
    _notice_objects(depsgraph)
    engine.scene_updated(depsgraph, is_frame=True)


def _notice_objects(depsgraph):
    """Where objects came, as by appending and duplicating, some may be live; where they went, it is told. Blender tells
    of collections then, and in no frame of an animation."""
    if _is_unknown:
        _begin()
    elif depsgraph.id_type_updated('COLLECTION'):
        _tell(rooms.ALL.objects_changed)
        roll.search()


@persistent
def meanvalue_leave_file(*_):
    """Another file or state is to come."""
    global _is_unknown
    _is_unknown = True
    engine.forget()


@persistent
def meanvalue_look_again(*_):
    global _is_unknown
    _is_unknown = False
    object_model.clear()
    _tell(rooms.ALL.forget)
    engine.look_for_live_objects()


@persistent
def meanvalue_another_file(*_):
    session.cache.clear()
    engine.meanvalue_render_ended()
    _begin()


def _begin():
    _tell(rooms.ALL.another_file)
    meanvalue_look_again()


@persistent
def meanvalue_save(*_):
    _tell(rooms.ALL.about_to_save)


_HANDLERS = (
    ("depsgraph_update_post", meanvalue_scene_updated),
    ("frame_change_post", meanvalue_frame_changed),
    ("undo_pre", meanvalue_leave_file),
    ("redo_pre", meanvalue_leave_file),
    ("undo_post", meanvalue_look_again),
    ("redo_post", meanvalue_look_again),
    ("load_pre", meanvalue_leave_file),
    ("load_post", meanvalue_another_file),
    ("save_pre", meanvalue_save),
    ("render_init", engine.meanvalue_render_started),
    ("render_complete", engine.meanvalue_render_ended),
    ("render_cancel", engine.meanvalue_render_ended),
)


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
    _drop_handlers()
    for list_name, handler in _HANDLERS:
        getattr(bpy.app.handlers, list_name).append(handler)
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
    _drop_handlers()
    rooms.take_in(())
    for owner in OWNERS:
        delattr(owner, ids.OBJECT_PROPERTY)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
    job.cancel_all()
    object_model.clear()
    session.cache.clear()


def _drop_handlers():
    """By name: after reloading the add-on, handlers of the former one are other functions."""
    global _is_unknown
    _is_unknown = True
    for list_name, handler in _HANDLERS:
        handlers = getattr(bpy.app.handlers, list_name)
        handlers[:] = [other for other in handlers if getattr(other, "__name__", "") != handler.__name__]
    engine.shut_down()
