# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel and the overlay read of objects: once for both, and in slices between redraws if the mesh is big."""

import math

import bpy

from .. import compat
from . import views
from .scene_reading import SceneReading

#: How long is read at a time, and how long Blender is left alone between.
SLICE_SECONDS = 0.01
PAUSE_SECONDS = 0.001

#: Objects whose arrays are kept.
MOST = 4

_known = {}  # session key: (name of the object, SceneReading), the latest asked for last


def finished(obj):
    """The finished SceneReading of `obj`; None while it is read, then the 3D Views are drawn again once it is there.

    In the background, where nothing is drawn, it is read at once.
    """
    key = compat.session_key(obj)
    _name, reading = _known.pop(key, (None, None))
    if reading is None or not reading.fits(obj):
        reading = SceneReading(obj)
    _known[key] = obj.name, reading
    while len(_known) > MOST:
        del _known[next(iter(_known))]
    if reading.go_on(obj, math.inf if bpy.app.background else SLICE_SECONDS):
        return reading
    if not bpy.app.timers.is_registered(_go_on):
        bpy.app.timers.register(_go_on, first_interval=PAUSE_SECONDS)
    return None


def known(obj):
    """The SceneReading of `obj` if there is one, finished or not, else None. For what only looks: see finished()."""
    return _known.get(compat.session_key(obj), (None, None))[1]


def forget(obj):
    """The object was edited."""
    _known.pop(compat.session_key(obj), None)


def clear():
    _known.clear()
    if bpy.app.timers.is_registered(_go_on):
        bpy.app.timers.unregister(_go_on)


def _go_on():
    """Timer: None ends it, a number calls it again after so many seconds."""
    for key, (name, reading) in list(_known.items()):
        if reading.is_finished:
            continue
        obj = bpy.data.objects.get(name)
        if obj is None or compat.session_key(obj) != key or obj.data.is_editmode or not reading.fits(obj):
            del _known[key]
            continue
        if reading.go_on(obj, SLICE_SECONDS):
            views.draw_again()
        return PAUSE_SECONDS
    return None
