# SPDX-License-Identifier: GPL-3.0-or-later
"""What is known of each object, in one place: what was read of it, and whether it has changed since.

Panel, overlay, live posing and operators ask the ObjectModel of an object. Each remembers the `stamp` that its own
knowledge is of, and looks again when the model has another one. Nothing of Blender's is held, so that undo, loading and
deleting leave nothing behind: objects are known by what tells them apart while the file is open.
"""

import enum
import itertools
import math
import time
from typing import NamedTuple

import numpy as np

from .. import compat
from ..posing.bridge import scene_input
from . import scene_reading, shape_keys

#: How long an object has to be left alone before what only shows it reads it again.
QUIET_SECONDS = 0.3

#: How long the rest shape is believed to be as it was read.
BELIEVED_SECONDS = 0.25

#: Objects whose arrays are kept.
MOST = 4

clock = time.monotonic

_models = {}  # session key: ObjectModel, the one whose arrays were asked for last at the end
_numbers = itertools.count(1)  # of revisions; no two models ever have the same


class Change(enum.Enum):
    """What Blender has told of an object."""

    RIG = "it was moved, or what its modifiers make of the mesh was"
    SLIDERS = "its shape keys are mixed otherwise; in later Blenders their points may be others too"
    KEYS = "its shape keys were written to"
    MESH = "anything of it"


class Stamp(NamedTuple):
    """settings rises where the quick signature has changed, content where Blender told of an edit."""

    settings: int
    content: int


class ObjectModel:
    """stamp         another one means: the object may be another by now
    rig_revision     rises when modifiers show the same mesh elsewhere, as a rig does that moves
    is_doubtful      what Blender told as our own writing may have hidden an edit: see confirm()
    is_watched       panel or overlay show it, and want to be drawn again after an edit
    is_awaited       of these one waits until it is read
    """

    def __init__(self, obj):
        self.name = obj.name
        self.stamp = Stamp(next(_numbers), next(_numbers))
        self.rig_revision = next(_numbers)
        self.is_doubtful = self.is_watched = self.is_awaited = False
        self._signature = scene_reading.signature(obj)
        self._edited_at = self._doubted_at = -math.inf
        self._expects_echo = False
        self._rest_read_at = -math.inf
        self._restarts = 0
        self.drop_arrays()

    def drop_arrays(self):
        self._reading = None
        self._bind_input = None
        self._bind_input_stamp = None

    # Whether it has changed

    def notice(self, obj):
        """Looks for what Blender does not tell of: settings, and what a script does."""
        self.name = obj.name
        signature = scene_reading.signature(obj)
        if signature != self._signature:
            self._signature = signature
            self.stamp = self.stamp._replace(settings=next(_numbers))

    def told(self, obj, change):
        """Blender has evaluated the object since `change`. Returns whether that was an edit, not our own writing."""
        if change is Change.RIG:
            return False
        if self._is_only_mixed(obj) if change is Change.SLIDERS else self._is_echo(obj, change):
            self.doubt()
            return False
        self.edited(keeps_groups=change is Change.KEYS)
        return True

    def edited(self, keeps_groups=False):
        """The object is another one now. keeps_groups: but not its faces, nor the members of its vertex groups."""
        self.stamp = self.stamp._replace(content=next(_numbers))
        self._edited_at = clock()
        self._expects_echo = False
        if not keeps_groups:
            self._drop_reading()

    def rig_moved(self):
        self.rig_revision = next(_numbers)

    def wrote(self):
        """Blender will tell of what was written to the object's shape keys just now: an echo."""
        self._expects_echo = True

    def doubt(self):
        """The object may have been edited: what was read is not to be believed, but nobody has to hurry."""
        self.is_doubtful = True
        self._doubted_at = clock()
        self._drop_reading()

    def is_current(self, stamp, quiet_seconds=0.0):
        """Whether what is known from `stamp` need not be read again: it is as it was, or has been edited for less than
        `quiet_seconds`."""
        if stamp is None or stamp.settings != self.stamp.settings:
            return False
        if self.is_doubtful and clock() - self._doubted_at >= QUIET_SECONDS:
            return False
        return stamp.content == self.stamp.content or clock() - self._edited_at < quiet_seconds

    @property
    def quiet_in(self):
        """Seconds until it has been left alone for QUIET_SECONDS; 0 if it has."""
        return max(0.0, self._edited_at + QUIET_SECONDS - clock())

    def _drop_reading(self):
        if self._reading is not None:
            self._restarts += not self._reading.is_finished
            self._reading = None

    def _is_echo(self, obj, change):
        """Where Blender tells of shape keys alone, it is ours; else an edit of the rest shape may be told with it."""
        is_expected, self._expects_echo = self._expects_echo, False
        if not is_expected or scene_reading.signature(obj) != self._signature:
            return False
        return change is Change.KEYS or self._is_rest_unchanged(obj)

    def _is_only_mixed(self, obj):
        keys = obj.data.shape_keys
        if self._bind_input is None or not compat.points_tell_as_sliders(keys.reference_key):
            return True
        return np.array_equal(shape_keys.positions(keys.reference_key), self._bind_input.rest)

    def _is_rest_unchanged(self, obj):
        """Reading takes as long as writing the result in 3.4, so what was read is believed for a moment."""
        keys = obj.data.shape_keys
        if keys is None:
            return False
        if self._bind_input is None or clock() < self._rest_read_at + BELIEVED_SECONDS:
            return True
        self._rest_read_at = clock()
        return np.array_equal(shape_keys.positions(keys.reference_key), self._bind_input.rest)

    # What was read of it

    @property
    def reading(self):
        """The SceneReading since the last edit, finished or not, or None. For what only looks: see read_on()."""
        return self._reading

    def read_on(self, obj, seconds=math.inf):
        """Reads for about so long what is not read yet; in one go where edits come faster than that.

        Returns whether all is read.
        """
        _keep_arrays_of(self)
        self.notice(obj)
        if self._reading is None or not self._reading.fits(obj):
            self._reading = scene_reading.SceneReading(obj)
        if not self._reading.go_on(obj, seconds if self._restarts < scene_reading.MOST_RESTARTS else math.inf):
            return False
        self._restarts = 0
        return True

    def bind_input(self, obj):
        """The BindInput, of what read_on() has read; the same one until there is an edit. @throws SceneError."""
        if self.is_doubtful:
            self.confirm(obj)
        if self._bind_input is None or self._bind_input_stamp != self.stamp:
            self._take(scene_input.gather(obj, self._reading))
        return self._bind_input

    def confirm(self, obj):
        """Clears a doubt, once read_on() has read all anew. Returns whether it was right: there was an edit.

        @throws SceneError.
        """
        self.is_doubtful = False
        if self._bind_input is None or self._bind_input_stamp != self.stamp:
            return False  # nobody has taken what is in doubt
        found = scene_input.gather(obj, self._reading)
        if self._bind_input.fingerprint == found.fingerprint:
            return False
        reading = self._reading
        self.edited()
        self._reading = reading
        self._take(found)
        return True

    def _take(self, bind_input):
        self._bind_input, self._bind_input_stamp = bind_input, self.stamp
        self._rest_read_at = clock()


def of(obj):
    """The ObjectModel of a mesh object, with what Blender does not tell of noticed."""
    key = compat.session_key(obj)
    model = _models.get(key)
    if model is None:
        model = _models[key] = ObjectModel(obj)
    else:
        model.notice(obj)
    return model


def known(obj):
    """The ObjectModel of `obj` if somebody has asked for it, else None."""
    return _models.get(compat.session_key(obj))


def known_models():
    """(session key, ObjectModel) of all."""
    return list(_models.items())


def edited(obj):
    """The add-on itself has changed what `obj` is posed by."""
    model = known(obj)
    if model is not None:
        model.edited()


def rig_revision(obj):
    """Rises when modifiers show the mesh of `obj` elsewhere, though the mesh is the same: a rig that moves does so."""
    return of(obj).rig_revision


def quiet_in():
    """Seconds until all that is shown has been left alone long enough; 0 if it has."""
    return max((model.quiet_in for model in _models.values() if model.is_watched), default=0.0)


def forget(key):
    _models.pop(key, None)


def clear():
    _models.clear()


def _keep_arrays_of(model):
    key = next((key for key, each in _models.items() if each is model), None)
    if key is None:
        return
    _models[key] = _models.pop(key)
    for other in list(_models.values())[:-MOST]:
        other.drop_arrays()
