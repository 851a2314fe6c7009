# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape keys that are driven, or show how a mesh bends, as Blender mixes them: `rest + sum of value * offset`."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...solver.core.fingerprint import digest

#: Why a key is left alone that could be driven.
WITHOUT_EFFECT = "without effect"


@dataclass(frozen=True)
class Slider:
    """That of a shape key. low, high: how far it goes; relative: the key that it is relative to; group: the vertex
    group that says how much it counts where, or ""."""

    name: str
    low: float
    high: float
    relative: str
    group: str = ""


@dataclass(frozen=True, eq=False)
class KeyShapes:
    """What s sliders do to a mesh of n vertices.

    rest: n x 3 float32, the reference key; points: {name of a key: n x 3 float32} of the sliders' own keys and of those
    that they are relative to
    masks: {vertex group: n float64, 0 to 1}
    left_alone: ((name, why in a word or two), ...) of the other keys
    """

    sliders: tuple
    rest: np.ndarray
    points: dict
    masks: dict
    left_alone: tuple = ()

    @property
    def names(self):
        return tuple(slider.name for slider in self.sliders)

    @property
    def bounds(self):
        """(2, s) float64: how far the sliders go."""
        return np.array([(slider.low, slider.high) for slider in self.sliders], np.float64).T

    @cached_property
    def revision(self):
        """Digest of all that the sliders do."""
        arrays = (*self.points.values(), *self.masks.values())
        return digest(self.rest, repr(self.sliders), repr(self.left_alone), *arrays)

    def offset(self, number, rows=slice(None)):
        """float64: how far a slider at 1 moves each vertex; rows: which vertices."""
        slider = self.sliders[number]
        moved = self.points[slider.name][rows].astype(np.float64) - self.points[slider.relative][rows]
        mask = self.masks.get(slider.group)
        return moved if mask is None else mask[rows, None] * moved

    def mixed(self, values):
        """n x 3 float64: where the sliders at `values`, (s,), have each vertex."""
        result = self.rest.astype(np.float64)
        for number in np.flatnonzero(values):
            result += values[number] * self.offset(number)
        return result

    def fit_input(self, anchors):
        """(rest (m, 3), shapes (s, m, 3), anchors (k,)) float64 and int, as meanvalue.SliderFit takes them: of the
        anchors (vertex indices) and the vertex that each slider moves the farthest, since others do not matter."""
        numbers = range(len(self.sliders))
        farthest = [(self.offset(number) ** 2).sum(axis=1).argmax() for number in numbers]
        rows, places = np.unique(np.concatenate([anchors, farthest]), return_inverse=True)
        rest = self.rest[rows].astype(np.float64)
        shapes = np.array([rest + self.offset(number, rows) for number in numbers])
        return rest, shapes, places[: len(anchors)]

    def shapes(self):
        """The n x 3 float64 shape with each of the sliders at 1, one after the other."""
        for number in range(len(self.sliders)):
            yield self.rest + self.offset(number)

    def with_effect(self):
        """The KeyShapes of the sliders that move something; the others are left alone."""
        idle = {slider.name for number, slider in enumerate(self.sliders) if not self.offset(number).any()}
        return replace(
            self,
            sliders=tuple(slider for slider in self.sliders if slider.name not in idle),
            left_alone=(*self.left_alone, *((name, WITHOUT_EFFECT) for name in self.names if name in idle)),
        )
