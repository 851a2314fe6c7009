# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender tells us: that objects were edited or moved, that undo or loading replaced everything.

Live posing follows what moved (live/engine.py); all else only forgets or marks. Blender calls handlers for every frame
of every scene: nothing may be gone through there unless something of ours follows or is shown.
"""

import bpy
from bpy.app.handlers import persistent

from .live import engine, roll
from .rooms import ALL
from .scene import object_model
from .solver import session

_is_unknown = True  # what the file has: the add-on may be enabled in any, and nobody tells if undo or loading failed


def _tell(listeners, *arguments):
    for hear in listeners:
        hear(*arguments)


@persistent
def meanvalue_scene_updated(_scene, depsgraph):
    if depsgraph.mode == 'RENDER':  # on a thread of its own
        return
    _notice_objects(depsgraph)
    _tell(ALL.scene_updated)
    active = depsgraph.view_layer.objects.active
    state = (active.name, active.mode) if active is not None else None
    layer = depsgraph.scene.name, depsgraph.view_layer.name
    if state != _last_active.get(layer):
        _last_active[layer] = state
        if active is not None:
            _tell(ALL.chosen, active)
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
        _tell(ALL.objects_changed)
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
    _tell(ALL.forget)
    engine.look_for_live_objects()


@persistent
def meanvalue_another_file(*_):
    session.cache.clear()
    engine.meanvalue_render_ended()
    _begin()


def _begin():
    _tell(ALL.another_file)
    meanvalue_look_again()


@persistent
def meanvalue_save(*_):
    _tell(ALL.about_to_save)


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


_last_active = {}  # (scene, view layer): name and mode of its active object when the handler saw it last


def register():
    unregister()
    for list_name, handler in _HANDLERS:
        getattr(bpy.app.handlers, list_name).append(handler)


def unregister():
    """By name: after reloading the add-on, handlers of the former one are other functions."""
    global _is_unknown
    _is_unknown = True
    for list_name, handler in _HANDLERS:
        handlers = getattr(bpy.app.handlers, list_name)
        handlers[:] = [other for other in handlers if getattr(other, "__name__", "") != handler.__name__]
    engine.shut_down()
