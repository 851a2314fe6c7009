# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads shape keys one after the other, so that nobody has to wait for many of a big mesh."""

import math
import time

from . import shape_keys, vertex_groups
from .core.finite import require_finite


class KeyReading:
    """What kinds of readings as scene/object_model.py wants them have in common, where shape keys are read.

    Subclasses say which: signature(obj), the Sliders that __init__() is given, and result(obj), of parts().
    Nothing of Blender's is kept. What was read is worth nothing once the object was edited.
    """

    def __init__(self, obj, sliders):
        self._signature = self.signature(obj)
        self._sliders = tuple(sliders)
        self._unread = list(dict.fromkeys(name for slider in sliders for name in (slider.name, slider.relative)))
        self._points = {}
        self._weights = vertex_groups.Reading(obj, {slider.group for slider in sliders if slider.group})

    @classmethod
    def gather(cls, obj):
        """The result for `obj`, read in one go. @throws SceneError."""
        reading = cls(obj)
        reading.go_on(obj)
        return reading.result(obj)

    def fits(self, obj):
        return self._signature == self.signature(obj)

    def go_on(self, obj, seconds=math.inf):
        """Reads for about so long. Returns whether all is read. @throws SceneError."""
        until = time.monotonic() + seconds
        while self._unread:
            name = self._unread.pop(0)
            self._points[name] = shape_keys.checked(obj, name)
            if time.monotonic() >= until:
                return False
        return self._weights.go_on(obj, until - time.monotonic())

    def parts(self, obj):
        """The arguments of a KeyShapes, once all is read. @throws SceneError."""
        rest = shape_keys.rest_positions(obj.data)
        require_finite(rest, "rest shape")
        return {"sliders": self._sliders, "rest": rest, "points": self._points, "masks": self._weights.weights}

    @staticmethod
    def shapes(found):
        return [("", found.rest), *found.points.items()]
