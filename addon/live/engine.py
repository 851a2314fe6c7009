# SPDX-License-Identifier: GPL-3.0-or-later
"""All objects that are live: who they are, when they are looked at, and when they are left alone.

Rooms bring the kinds of followers: classes beside live/following.py, with a LABEL, whose asks_for(obj) says whether
`obj` is theirs; turn(obj, is_on) switches that.

Nothing of Blender's is held: objects are known by what tells them apart while the file is open, and looked up by name.
"""

import contextlib

import bpy

from .. import compat, wording
from ..scene import object_model, subject, views
from . import render_notes, updates
from .states import TICK_SECONDS
from .telling import reporting

#: How often it is looked whether there is anything to tell, while nothing is to be done: a render cannot call a timer.
REST_SECONDS = 0.5

_kinds = []  # classes of followers
_followers = {}  # identity of the object: its follower
_must_search = True  # for live objects: the add-on may be enabled in a file that has some
_said = None  # what the panels showed last
_is_rendering = False
_is_updating = False
_is_held = False
_has_missed = False  # an update came while objects were looked at


def add_kind(kind):
    _kinds.append(kind)


def remove_kind(kind):
    _kinds.remove(kind)


def kinds_on(obj):
    """The kinds of followers that are turned on for `obj`."""
    return [kind for kind in _kinds if kind.asks_for(obj)]


def turn_others_off(obj, kind):
    """Of all that shapes a mesh at once, one is on."""
    for other in kinds_on(obj):
        if other is not kind:
            other.turn(obj, False)


def identity(obj):
    """Tells an object with its mesh apart from all others while the file is open, whatever they are called."""
    return compat.session_key(obj), compat.session_key(obj.data) if obj.data else None


def scene_updated(depsgraph):
    """Blender evaluated the scene. Returns whether an object was edited that panel or overlay show."""
    if depsgraph.mode == 'RENDER' or len(depsgraph.updates) == 0:
        return False
    _notice_end_of_rendering()
    if _must_search:
        look_for_live_objects()
    is_to_be_drawn = _take_note(depsgraph)
    follow_all()
    return is_to_be_drawn


def frame_changed(depsgraph):
    if depsgraph.mode == 'RENDER':
        for obj, follower in _live_objects() if _is_rendering else ():
            with reporting(follower):
                render_notes.look(identity(obj), obj, follower, depsgraph)
        return
    _notice_end_of_rendering()
    _take_note(depsgraph)
    follow_all()


def _take_note(depsgraph):
    """Tells the models of the objects what Blender evaluated, and finds objects that were turned live.

    Returns as scene_updated().
    """
    is_to_be_drawn = False
    for obj, change, is_rigged in updates.of(depsgraph):
        model = object_model.known(obj)
        if model is not None:
            if is_rigged:
                model.rig_moved()
            is_to_be_drawn |= model.told(obj, change) and model.is_watched
        if follower_of(obj) is None and _kind(obj) is not None:
            _followers[identity(obj)] = _kind(obj)(obj, hears_itself=not bpy.app.background)
    return is_to_be_drawn


def follow_all():
    """Every live object takes its controls, or its sliders, where they are."""
    global _has_missed
    if _is_updating:
        _has_missed = True
    if _is_updating or _is_rendering or _is_held:
        return
    with _updating():
        for obj, follower in _objects_in_charge():
            with reporting(follower):
                if bpy.app.background:
                    follower.finish(obj)
                else:
                    follower.follow(obj)
    _keep_ticking()


@contextlib.contextmanager
def _updating():
    """Inside, handlers only take note: measuring a rig may have Blender evaluate the scene, which calls them."""
    global _is_updating
    _is_updating = True
    try:
        yield
    finally:
        _is_updating = False


def look_for_live_objects():
    """After loading or undo everything may be another: forget, and see which objects are live."""
    forget()
    _search()
    _keep_ticking()


def render_started():
    """While rendering, the mesh is left as it is: handlers run beside the interface then."""
    global _is_rendering
    _is_rendering = True
    unsettled = [each for each in _followers.items() if each[1].has_more_to_do and not each[1].is_resting]
    render_notes.begin([(key, follower.name) for key, follower in unsettled])


def render_ended():
    """May be called on the thread that renders: only tells."""
    global _is_rendering
    _is_rendering = False


def leave_file():
    """Another file or state is to come. If it cannot be read, Blender goes on with this one and does not say so."""
    global _must_search
    _must_search = True
    forget()


@contextlib.contextmanager
def held():
    """Inside, nothing follows: frames are gone through only to see where the controls are."""
    global _is_held
    before, _is_held = _is_held, True
    try:
        yield
    finally:
        _is_held = before


def forget():
    for follower in _followers.values():
        follower.stop()
    _followers.clear()
    render_notes.forget()


def another_file():
    render_ended()
    look_for_live_objects()


def shut_down():
    global _must_search
    _must_search = True
    forget()
    render_ended()
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)


def follower_of(obj):
    """The follower of a live object, or None."""
    return _followers.get(identity(obj))


def look_again(obj):
    """An operator has changed what `obj` is posed by: nothing that was known of it may be written any more."""
    object_model.edited(obj)
    follower = follower_of(obj)
    if follower is not None:
        follower.look_again()


def is_settled(obj):
    """Whether the mesh shows the settled answer to where the controls are, or live posing has no say in it."""
    follower = follower_of(obj)
    return follower is None or follower.is_settled(obj)


def status(obj):
    """What live posing has to say about `obj`: (text, whether it is a problem), or None if it is not live."""
    follower = follower_of(obj)
    if follower is None:
        return None
    note = render_notes.of(identity(obj))
    if note and not follower.problem and not obj.meanvalue.baked.target:
        return wording.sentence(note), True
    hidden = follower.why_hidden(obj)
    if hidden and not follower.problem:
        return wording.sentence(hidden), True
    return follower.text, follower.problem is not None and not follower.is_reading


def _kind(obj):
    """The class of the follower that `obj` asks for, or None."""
    if obj.type != 'MESH' or subject.object_problem(obj) is not None:
        return None
    return next(iter(kinds_on(obj)), None)


def _search():
    """Finds the live objects, whatever they are called by now; keeps what is known of them."""
    global _must_search
    _must_search = False
    known = dict(_followers)
    _followers.clear()
    for obj in bpy.data.objects:
        kind = _kind(obj)
        if kind is not None:
            follower = known.get(identity(obj))
            if type(follower) is kind:
                known.pop(identity(obj))
            else:
                follower = kind(obj, hears_itself=not bpy.app.background)
            follower.name = obj.name
            _followers[identity(obj)] = follower
    for key, follower in known.items():
        follower.stop()
        render_notes.forget(key)


def _live_objects():
    """(object, follower) of all that are live."""
    found = [(bpy.data.objects.get(follower.name), key, follower) for key, follower in _followers.items()]
    if any(obj is None or identity(obj) != key or _kind(obj) is not type(each) for obj, key, each in found):
        _search()
        found = [(bpy.data.objects[follower.name], key, follower) for key, follower in _followers.items()]
    return [(obj, follower) for obj, _, follower in found]


def _objects_in_charge():
    """(object, follower) of those that may write; of several with the same mesh all others give way."""
    writers = {}  # mesh: name of the object that writes its shape key
    for obj, follower in _live_objects():
        writer = writers.setdefault(obj.data.name, obj.name)
        if writer == obj.name:
            yield obj, follower
        else:
            follower.give_way(writer)


def _notice_end_of_rendering():
    """A render that fails to start never tells that it ended."""
    if _is_rendering and (bpy.app.background or not bpy.app.is_job_running('RENDER')):
        render_ended()


def _keep_ticking():
    """At once where a job runs: the timer may be waiting for the controls to rest."""
    if not _followers or bpy.app.background:
        return
    is_registered = bpy.app.timers.is_registered(_tick)
    if is_registered and any(follower.has_more_to_do for follower in _followers.values()):
        bpy.app.timers.unregister(_tick)
        is_registered = False
    if not is_registered:
        bpy.app.timers.register(_tick, first_interval=TICK_SECONDS)


def _tick():
    """Timer: None ends it, a number calls it again after so many seconds."""
    global _has_missed
    _notice_end_of_rendering()
    for note in render_notes.take_untold():
        views.pop_up("Mean-Value", wording.sentence(note))
    if _is_rendering or _is_held:
        return REST_SECONDS
    waits = []
    looks, _has_missed = _has_missed, False
    with _updating():
        for obj, follower in _objects_in_charge():
            with reporting(follower):
                waits.append(follower.tick(obj, looks))
    if _has_missed and waits:
        waits.append(TICK_SECONDS)
    _draw_status_again()
    return min((seconds for seconds in waits if seconds is not None), default=REST_SECONDS if waits else None)


def _draw_status_again():
    global _said
    saying = [follower.text for follower in _followers.values()]
    if saying == _said:
        return
    _said = saying
    views.draw_again('UI')
