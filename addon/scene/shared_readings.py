# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads what the panel and the overlay show of objects in slices between redraws, if the mesh is big."""

import math

import bpy

from .. import compat
from . import object_model, views

#: How long one slice of reading takes, and the pause after it.
SLICE_SECONDS = 0.01
PAUSE_SECONDS = 0.001


def finished(obj, kind):
    """The reading of `obj` if it is finished. Else None: it is read on, and then the 3D Views are drawn again.

    In the background, where nothing is drawn, it is read at once.
    """
    model = object_model.of(obj, kind)
    if _goes_on(obj, model, math.inf if bpy.app.background else SLICE_SECONDS):
        return model.reading
    model.is_awaited = True
    _schedule(PAUSE_SECONDS)
    return None


def look_again_when_quiet():
    """After an edit: reads again what is shown, once no edit came for a moment. Blender would not draw it by itself."""
    if not bpy.app.timers.is_registered(_read_on):  # if it is, reading goes on already
        _schedule(object_model.QUIET_SECONDS)


def stop():
    if bpy.app.timers.is_registered(_read_on):
        bpy.app.timers.unregister(_read_on)


def _schedule(seconds):
    """Has _read_on() called after so many seconds.

    Not in the background: timers are never called there, and one left over keeps the bpy module of 4.5 from ending.
    """
    stop()
    if not bpy.app.background:
        bpy.app.timers.register(_read_on, first_interval=seconds)


def _read_on():
    """Timer: None ends it, a number calls it again after so many seconds."""
    for key, model in object_model.known_models():
        if not model.is_awaited:
            continue
        obj = bpy.data.objects.get(model.name)
        if obj is None or compat.session_key(obj) != key[0]:
            object_model.forget(key)
        elif not obj.data.is_editmode and not _goes_on(obj, model, SLICE_SECONDS):
            return PAUSE_SECONDS
        model.is_awaited = False
        views.draw_again()
    remaining = object_model.quiet_in()
    if remaining > 0.0:
        return remaining
    views.draw_again()
    return None


def _goes_on(obj, model, seconds):
    """Reads and compares for about `seconds`. Returns whether all is done."""
    if model.reading is None:  # it was dropped, or left to a follower
        model.read_anew()
    while model.read_on(obj, seconds) and model.is_unchecked:
        if not model.compare_on(obj, seconds):
            return False
    return model.is_read(obj)
