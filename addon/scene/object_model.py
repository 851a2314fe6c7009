# SPDX-License-Identifier: GPL-3.0-or-later
"""What was read of objects, in one place, and whether it is still true: an ObjectModel of an object and a Kind of
reading, which rooms bring. Nothing of Blender's is held, so that undo, loading and deleting leave nothing behind.

Of an edit Blender tells; of our own writing too, and not which it is. So what is told as writing to shape keys alone is
compared with what was read and written last, when all is quiet.
"""

import enum
import itertools
import math
import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from .. import compat
from ..errors import MeanValueError
from . import kept, shape_keys

clock = time.monotonic

_models = {}  # (session key, kind): ObjectModel
_numbers = itertools.count(1)  # of revisions; no two models ever have the same


class Change(enum.Enum):
    """What Blender has told of an object."""

    RIG = "it was moved, or what its modifiers make of the mesh was"
    SLIDERS = "its shape keys are mixed otherwise; in later Blenders their points may be others too"
    KEYS = "its shape keys were written to"
    MESH = "anything of it"


class Kind(NamedTuple):
    """What is read of an object, as functions.

    signature(obj)    all that is quick to compare of what is read. Blender does not tell of all of it
    read(obj)         what it comes to, with nothing of Blender's; its `revision` is another one for other content.
                      @throws MeanValueError
    shapes(result)    [(name of a shape key, n x 3 float32)] that the result depends on, "" the rest shape
    written_key(obj)  the shape key that the add-on writes, or None if there is none yet
    """

    signature: Callable
    read: Callable
    shapes: Callable
    written_key: Callable


class ObjectModel:
    """What is known of one object by one Kind of reading.

    content       rises with every edit
    rig_revision  rises when modifiers show the same mesh elsewhere, as a rig does that moves
    written       n x 3 float32: what the add-on has written last, None where that is not what the key has
    overwritten   n x 3 float32: then what it was, if it was there before somebody edited the key; else None
    found         the result of what was read last, or None
    is_unchecked  Blender has told of writing to shape keys, which may be ours: see compare()
    """

    def __init__(self, obj, kind):
        self.kind = kind
        self.rig_revision, self.rig_moved_at = next(_numbers), -math.inf
        self.written = self.overwritten = self._rest = None
        self.is_unchecked = self._is_read_before = False
        self.content = next(_numbers)
        self.found = self._stamp = self._error = None

    # Whether it has changed

    def stamp(self, obj):
        """(signature of the Kind, content): another one means that the object may be another by now."""
        return self.kind.signature(obj), self.content

    def told(self, obj, change):
        """Blender has evaluated the object since `change`."""
        if change is Change.MESH:
            self.edited()
        is_written = change is Change.SLIDERS and compat.points_tell_as_sliders(obj.data.shape_keys.reference_key)
        if is_written or change is Change.KEYS:
            self.is_unchecked = self._is_read_before = True

    def edited(self):
        """The object is another one now."""
        self.content = next(_numbers)
        self.is_unchecked = self._is_read_before = True

    def rig_moved(self):
        self.rig_revision, self.rig_moved_at = next(_numbers), clock()

    def wrote(self, shape):
        """The add-on has written the n x 3 float32 `shape` to its key just now."""
        self.written, self.overwritten = shape, None
        self._rest = next((rest for name, rest in self._shapes() if not name), None)

    # What was read of it

    def is_read(self, obj):
        """Whether result() is of the object as it is, as far as Blender has told."""
        return self._stamp is not None and self.is_known and self._stamp == self.stamp(obj)

    def is_usable(self, obj):
        """Whether result() is of an object that is quick to take for this one, which may have been edited since."""
        return self.is_known and self._stamp is not None and self._stamp[0] == self.kind.signature(obj)

    @property
    def is_known(self):
        """Whether there is a result() of what was read last."""
        return self._error is not None or self.found is not None

    def read(self, obj):
        """Reads what is not read yet."""
        if self.is_read(obj):
            return
        former, self.found, self._error, self._stamp = self.found, None, None, self.stamp(obj)
        try:
            found = self.kind.read(obj)
            self.found = former if former is not None and former.revision == found.revision else found
        except MeanValueError as error:
            self._error = error
        self._is_read_before = False

    def result(self, obj):
        """What read() has read; the same one until there is other content. @throws MeanValueError."""
        if not self.is_known:
            self.read(obj)
        if self._error is not None:
            raise self._error
        return self.found

    def refuse(self, error):
        """What was read cannot be used: result() raises `error` until there is an edit."""
        self._error = error

    def compare(self, obj):
        """Compares what shape keys hold with what was read and written, if that may be another; reads what is."""
        if not self.is_unchecked:
            return
        shapes = self._shapes() if self._is_read_before else []  # what was read since is as it is
        if not all(np.array_equal(shape_keys.held(obj, name), shape) for name, shape in shapes):
            self.edited()
            self.read(obj)
        shapes = self._shapes()
        if self.written is not None:
            key = self.kind.written_key(obj)
            is_held = key is not None and np.array_equal(shape_keys.positions(key), self.written)
            if not is_held:  # where the rest shape is another, the key has only gone along
                is_edited = any(not name and np.array_equal(rest, self._rest) for name, rest in shapes)
                self.overwritten, self.written = self.written if is_edited else None, None
        self.is_unchecked = False

    def _shapes(self):
        return [] if self.found is None else self.kind.shapes(self.found)


def of(obj, kind):
    """The ObjectModel of a mesh object for a Kind of reading."""
    key = compat.session_key(obj), kind
    if key not in _models:
        _models[key] = ObjectModel(obj, kind)
    return _models[key]


def known_models(obj):
    """Those of an object."""
    key = compat.session_key(obj)
    return [model for (of, _kind), model in _models.items() if of == key]


def has_any():
    """Whether anything is known of any object since loading or undo."""
    return bool(_models) or kept.has_any()


def edited(obj):
    """The add-on itself has changed what `obj` is posed by."""
    for model in known_models(obj):
        model.edited()
        model.written = model.overwritten = None


def clear():
    _models.clear()
    kept.clear()
