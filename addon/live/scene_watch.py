# SPDX-License-Identifier: GPL-3.0-or-later
"""What live posing knows of an object, and whether that may have changed."""

import math
import time

import numpy as np

from ..bridge import bound_record, mirrors, scene_input, shape_keys
from ..bridge.scene_reading import MOST_RESTARTS
from ..core import fingerprint
from ..errors import StaleBindingError

#: How long the rest shape is believed to be as it was read, and how long all has to be quiet for other things.
QUIET_SECONDS = 0.25

clock = time.monotonic


class SceneWatch:
    """Reads an object a slice at a time, and tells the artist's edits from what live posing wrote itself.

    bind_input      the BindInput as it was read last, or None
    must_read       it may be another by now, and nothing may be done before it is read
    must_check      it may be another by now, which is looked for once all is quiet: an echo may have hidden an edit
    waits_for_edit  it cannot be posed as it is
    """

    def __init__(self):
        self.forget()

    def forget(self):
        self.bind_input = None
        self.must_read = True
        self.must_check = self.waits_for_edit = False
        self._reading = None
        self._restarts = 0  # of reading, since it was last finished
        self._settings = None
        self._expects_echo = False
        self._rest_read_at = -math.inf

    @property
    def is_reading(self):
        return self._reading is not None

    def stop_reading(self):
        self._reading = None

    def wrote(self):
        """Blender will call edited() for what was written."""
        self._expects_echo = True

    def edited(self, obj):
        """Blender updated the object. Returns whether that was only what we wrote ourselves."""
        if self._expects_echo and self._settings == _settings_of(obj) and self._is_rest_unchanged(obj):
            self._expects_echo = False
            self.must_check = True
            self._reading = None
            return True
        self.must_read = True
        self.waits_for_edit = self._expects_echo = False
        if self._reading is not None:
            self._reading = None
            self._restarts += 1
        return False

    def notice_settings(self, obj):
        """Blender does not tell of these."""
        if self._settings is not None and self._settings != _settings_of(obj):
            self.must_read, self.waits_for_edit = True, False

    def start_reading(self, obj):
        """@throws SceneError."""
        self._reading = scene_input.start_reading(obj)

    def read_on(self, obj, patience):
        """Reads for about so many seconds. Returns whether all is read, and then `bind_input` is good.

        @throws SceneError; StaleBindingError if the artist has to look before it is bound again.
        """
        if not self._reading.go_on(obj, patience if self._restarts < MOST_RESTARTS else math.inf):
            return False
        self._restarts = 0
        reading, self._reading = self._reading, None
        bind_input = scene_input.gather(obj, reading)
        _require_good_binding(obj, bind_input)
        self.bind_input = bind_input
        self.must_read = self.must_check = False
        self._rest_read_at = clock()
        self._settings = _settings_of(obj)
        return True

    def _is_rest_unchanged(self, obj):
        """What the artist did may be told together with our own writing. Reading takes as long as writing the result
        in 3.4, so what was read is believed for a moment."""
        keys = obj.data.shape_keys
        if keys is None:
            return False
        if clock() < self._rest_read_at + QUIET_SECONDS:
            return True
        self._rest_read_at = clock()
        return np.array_equal(shape_keys.positions(keys.reference_key), self.bind_input.rest)


def _require_good_binding(obj, bind_input):
    bound = bound_record.read_fingerprint(obj.meanvalue.bound)
    if bound is None:
        return
    reasons = fingerprint.stale_reasons(bound, bind_input.fingerprint)
    if fingerprint.needs_bind(reasons):
        changes = fingerprint.describe(reasons, bound, bind_input.fingerprint)
        raise StaleBindingError(f"{changes}. Check the handles and press Bind")


def _settings_of(obj):
    """All settings that a binding depends on and that are quick to compare."""
    settings = obj.meanvalue
    return (
        settings.method,
        settings.rigidity,
        settings.roi_group,
        settings.roi_invert,
        settings.result_key,
        mirrors.signature(obj),
        tuple(
            (group.name, group.is_enabled, group.follows, group.is_soft, group.strength)
            for group in settings.anchor_groups
        ),
    )
