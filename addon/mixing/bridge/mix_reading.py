# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the shape keys that are mixed."""

import math
import time

import numpy as np

from ... import ids, wording
from ...errors import SceneError
from ...scene import mesh_arrays, shape_keys, vertex_groups
from ...scene.core.finite import require_finite
from ..core.mix_input import MixInput, Slider
from . import mixed_keys


class MixReading:
    """Reads the shapes one after the other, so that nobody has to wait for many of a big mesh: a kind of reading as
    scene/object_model.py wants it.

    Nothing of Blender's is kept. What was read is worth nothing once the object was edited.
    """

    @staticmethod
    def signature(obj):
        keys = tuple((key.name, key.slider_min, key.slider_max, key.vertex_group) for key in mixed_keys.mixed(obj))
        return len(obj.data.vertices), keys

    @staticmethod
    def shapes(mix_input):
        named = ((slider.name, shape) for slider, shape in zip(mix_input.sliders, mix_input.shapes, strict=True))
        return [("", mix_input.rest), *named]

    @staticmethod
    def written_key(_obj):
        return ids.MIX_KEY

    def fits(self, obj):
        return self._signature == self.signature(obj)

    def __init__(self, obj):
        found = mixed_keys.problem(obj)
        if found:
            raise SceneError(found)
        self._signature = self.signature(obj)
        keys = mixed_keys.mixed(obj)
        self._sliders = tuple(Slider(key.name, key.slider_min, key.slider_max) for key in keys)
        self._groups = [key.vertex_group for key in keys]
        self._shapes = []
        self._weights = vertex_groups.Reading(obj, set(filter(None, self._groups)))

    @property
    def share(self):
        return len(self._shapes) / (len(self._sliders) + 1)

    def go_on(self, obj, seconds=math.inf):
        """Reads for about so long. Returns whether all is read. @throws SceneError."""
        until = time.monotonic() + seconds
        while len(self._shapes) < len(self._sliders):
            name = self._sliders[len(self._shapes)].name
            self._shapes.append(shape_keys.checked(obj, name))
            _require_extent(name, self._shapes[-1])
            if time.monotonic() >= until:
                return False
        return self._weights.go_on(obj, until - time.monotonic())

    def result(self, obj):
        """The MixInput, once all is read; after that the shapes are to be read again. @throws SceneError."""
        rest = shape_keys.rest_positions(obj.data)
        require_finite(rest, "the rest shape")
        _require_extent(obj.data.shape_keys.reference_key.name, rest)
        shapes, self._shapes = np.array(self._shapes), []
        return MixInput(
            sliders=self._sliders,
            rest=rest,
            shapes=shapes,
            masks=self._masks_of(len(rest)),
            triangles=mesh_arrays.triangles(obj.data, rest),
        )

    def _masks_of(self, count):
        if not any(self._groups):
            return None
        weights = self._weights.weights
        return np.array([weights[group] if group else np.ones(count) for group in self._groups])


def gather(obj):
    """The MixInput of `obj`, read in one go. @throws SceneError."""
    reading = MixReading(obj)
    reading.go_on(obj)
    return reading.result(obj)


def _require_extent(name, shape):
    if len(shape) == 0 or (shape == shape[0]).all():
        raise SceneError(
            f"Shape key '{name}' has {wording.vertices(len(shape))}, all in one place, so nothing can turn. Mute it, "
            "or give it a shape"
        )
