# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads what the panel and the overlay show of objects in slices between redraws, if the mesh is big."""

import contextlib
import math

import bpy

from .. import compat
from ..errors import SceneError
from . import object_model, views

#: How long is read at a time, and how long Blender is left alone between.
SLICE_SECONDS = 0.01
PAUSE_SECONDS = 0.001


def finished(obj):
    """The finished SceneReading of `obj`; None while it is read, then the 3D Views are drawn again once it is there.

    In the background, where nothing is drawn, it is read at once.
    """
    model = object_model.of(obj)
    if model.read_on(obj, math.inf if bpy.app.background else SLICE_SECONDS):
        if model.is_doubtful:
            with contextlib.suppress(SceneError):  # told by whoever needs the handles
                model.confirm(obj)
        return model.reading
    model.is_awaited = True
    if not bpy.app.timers.is_registered(_go_on):
        bpy.app.timers.register(_go_on, first_interval=PAUSE_SECONDS)
    return None


def known(obj):
    """The SceneReading of `obj` if there is one, finished or not, else None. For what only looks: see finished()."""
    model = object_model.known(obj)
    return model.reading if model else None


def stop():
    if bpy.app.timers.is_registered(_go_on):
        bpy.app.timers.unregister(_go_on)


def _go_on():
    """Timer: None ends it, a number calls it again after so many seconds."""
    for key, model in object_model.known_models():
        if not model.is_awaited:
            continue
        obj = bpy.data.objects.get(model.name)
        if obj is None or compat.session_key(obj) != key:
            object_model.forget(key)
        elif _goes_on(obj, model) and not model.read_on(obj, SLICE_SECONDS):
            return PAUSE_SECONDS
        model.is_awaited = False
        views.draw_again()
    return None


def _goes_on(obj, model):
    return model.reading is not None and model.reading.fits(obj) and not obj.data.is_editmode
