# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel and the overlay read of objects: once for both, and in slices between redraws if the mesh is big."""

import math
from dataclasses import dataclass

import bpy

from .. import compat
from . import views
from .scene_reading import MOST_RESTARTS, SceneReading

#: How long is read at a time, and how long Blender is left alone between.
SLICE_SECONDS = 0.01
PAUSE_SECONDS = 0.001

#: Objects whose arrays are kept.
MOST = 4


@dataclass(eq=False)
class _Entry:
    """restarts: how often it was edited before all was read; is_awaited: somebody was told to wait for it."""

    name: str
    reading: SceneReading | None = None
    restarts: int = 0
    is_awaited: bool = False


_known = {}  # session key: _Entry, the latest asked for last


def finished(obj):
    """The finished SceneReading of `obj`; None while it is read, then the 3D Views are drawn again once it is there.

    In the background, where nothing is drawn, it is read at once.
    """
    key = compat.session_key(obj)
    entry = _known[key] = _known.pop(key, None) or _Entry(obj.name)
    entry.name = obj.name
    while len(_known) > MOST:
        del _known[next(iter(_known))]
    if entry.reading is None or not entry.reading.fits(obj):
        entry.reading = SceneReading(obj)
    is_impatient = bpy.app.background or entry.restarts >= MOST_RESTARTS
    if entry.reading.go_on(obj, math.inf if is_impatient else SLICE_SECONDS):
        entry.restarts = 0
        return entry.reading
    entry.is_awaited = True
    if not bpy.app.timers.is_registered(_go_on):
        bpy.app.timers.register(_go_on, first_interval=PAUSE_SECONDS)
    return None


def known(obj):
    """The SceneReading of `obj` if there is one, finished or not, else None. For what only looks: see finished()."""
    entry = _known.get(compat.session_key(obj))
    return entry.reading if entry else None


def forget(obj):
    """The object was edited."""
    entry = _known.get(compat.session_key(obj))
    if entry is not None and entry.reading is not None:
        entry.restarts += not entry.reading.is_finished
        entry.reading = None


def doubt(obj):
    """The object may have been edited. What is being read is not begun anew for that."""
    entry = _known.get(compat.session_key(obj))
    if entry is not None and entry.reading is not None and entry.reading.is_finished:
        entry.reading = None


def clear():
    _known.clear()
    if bpy.app.timers.is_registered(_go_on):
        bpy.app.timers.unregister(_go_on)


def _go_on():
    """Timer: None ends it, a number calls it again after so many seconds."""
    for key, entry in list(_known.items()):
        if not entry.is_awaited:
            continue
        obj = bpy.data.objects.get(entry.name)
        if obj is None or compat.session_key(obj) != key:
            del _known[key]
        elif entry.reading is not None and entry.reading.fits(obj) and not obj.data.is_editmode:
            if not entry.reading.go_on(obj, SLICE_SECONDS):
                return PAUSE_SECONDS
            entry.restarts = 0
        entry.is_awaited = False
        views.draw_again()
    return None
