# SPDX-License-Identifier: GPL-3.0-or-later
"""All objects that are live: who they are, when they are looked at, and when they are left alone.

Objects are known by name and looked up at every call; nothing of Blender's is held.
"""

import bpy

from .follower import Follower

_followers = {}  # object name: Follower
_must_search = True  # for live objects: the add-on may be enabled in a file that has some
_said = None  # what the panels showed last
_is_rendering = False
_is_updating = False


def scene_updated(updates):
    """Blender evaluated the scene; `updates` are what it evaluated again."""
    if _must_search:
        look_for_live_objects()
    for update in updates:
        if isinstance(update.id, bpy.types.Object) and update.is_updated_geometry:
            _note_edit(update.id.original)
    if updates:
        follow_all()


def follow_all():
    """Every live object takes its controls where they are."""
    global _is_updating
    if _is_updating or _is_rendering:
        return
    _is_updating = True
    try:
        writers = {}  # (mesh, shape key): name of the object that writes it
        for obj, follower in _live_objects():
            writer = writers.setdefault((obj.data.name, obj.meanvalue.result_key), obj.name)
            if writer != obj.name:
                follower.give_way(writer, obj.meanvalue.result_key)
            elif bpy.app.background:
                follower.finish(obj)
            else:
                follower.follow(obj)
    finally:
        _is_updating = False
    _keep_ticking()


def look_for_live_objects():
    """After loading or undo everything may be another: forget, and see which objects are live."""
    global _must_search
    _must_search = False
    forget()
    for obj in bpy.data.objects:
        if _is_live(obj):
            _followers[obj.name] = _new_follower(obj)
    _keep_ticking()


def render_started():
    """While rendering, the mesh is left as it is: handlers run beside the interface then."""
    global _is_rendering
    _is_rendering = True
    for follower in _followers.values():
        follower.look_again()


def render_ended():
    global _is_rendering
    _is_rendering = False
    _keep_ticking()


def forget():
    for follower in _followers.values():
        follower.stop()
    _followers.clear()


def shut_down():
    global _must_search
    _must_search = True
    forget()
    render_ended()
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)


def settle(obj):
    """Waits for the answer to where the controls are now, where `obj` is live: what is kept must not lag behind."""
    follower = _followers.get(obj.name)
    if follower is not None and not _is_rendering:
        follower.finish(obj)


def status(obj):
    """What live posing has to say about `obj`: (text, whether it is a problem), or None if it is not live."""
    follower = _followers.get(obj.name)
    return None if follower is None else (follower.text, follower.problem is not None)


def _note_edit(obj):
    follower = _followers.get(obj.name)
    if follower is not None:
        follower.edited(obj)
    elif _is_live(obj):
        _followers[obj.name] = _new_follower(obj)


def _new_follower(obj):
    return Follower(obj, hears_itself=not bpy.app.background)


def _is_live(obj):
    return obj.type == 'MESH' and obj.library is None and obj.meanvalue.live


def _live_objects():
    """(object, Follower) of all that are still there and live; the others are forgotten."""
    found = []
    for name, follower in list(_followers.items()):
        obj = bpy.data.objects.get(name)
        if obj is None or not _is_live(obj):
            follower.stop()
            del _followers[name]
        else:
            found.append((obj, follower))
    return found


def _keep_ticking():
    if _followers and not bpy.app.background and not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick, first_interval=0.01)


def _tick():
    """Timer: None ends it, a number calls it again after so many seconds."""
    if _is_rendering:
        return None
    waits = [follower.tick(obj) for obj, follower in _live_objects()]
    waits = [seconds for seconds in waits if seconds is not None]
    _draw_status_again()
    return min(waits, default=None)


def _draw_status_again():
    global _said
    saying = [follower.text for follower in _followers.values()]
    if saying == _said:
        return
    _said = saying
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == 'VIEW_3D':
                for region in area.regions:
                    if region.type == 'UI':
                        region.tag_redraw()
