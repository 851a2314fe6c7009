# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads shape keys and what masks them."""

from ..errors import SceneError
from . import shape_keys, vertex_groups
from .core.finite import require_finite
from .core.key_shapes import Slider


def slider_of(obj, key):
    """The Slider of a shape key of `obj`. A vertex group that is gone masks nothing, as in Blender."""
    group = key.vertex_group if key.vertex_group in obj.vertex_groups else ""
    return Slider(key.name, key.slider_min, key.slider_max, key.relative_key.name, group)


class KeyReading:
    """What kinds of readings as scene/object_model.py wants them have in common, where shape keys are read.

    Subclasses say which, by static functions: signature(obj), problem(obj), why there is nothing to read, or None, and
    sliders(obj), the Sliders; and define result(obj), of parts().
    Nothing of Blender's is kept. What was read is worth nothing once the object was edited.
    """

    def __init__(self, obj):
        """@throws SceneError."""
        found = self.problem(obj)
        if found:
            raise SceneError(found)
        self._sliders = tuple(self.sliders(obj))
        names = dict.fromkeys(name for slider in self._sliders for name in (slider.name, slider.relative))
        self._points = {name: shape_keys.checked(obj, name) for name in names}
        self._weights = vertex_groups.weights(obj, {slider.group for slider in self._sliders if slider.group})

    @classmethod
    def gather(cls, obj):
        """The result for `obj`. @throws SceneError."""
        return cls(obj).result(obj)

    def parts(self, obj):
        """The arguments of a KeyShapes. @throws SceneError."""
        rest = shape_keys.rest_positions(obj.data)
        require_finite(rest, "rest shape")
        return {"sliders": self._sliders, "rest": rest, "points": self._points, "masks": self._weights}

    @staticmethod
    def shapes(found):
        return [("", found.rest), *found.points.items()]
