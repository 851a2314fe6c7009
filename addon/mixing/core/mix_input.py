# SPDX-License-Identifier: GPL-3.0-or-later
"""The shapes that are mixed, and what their sliders mean."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...solver.core.fingerprint import digest


@dataclass(frozen=True)
class Slider:
    """That of a shape key. low, high: how far it goes."""

    name: str
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class MixInput:
    """The shapes of k shape keys of a mesh of n vertices."""

    sliders: tuple
    rest: np.ndarray  # n x 3 float32
    shapes: np.ndarray  # k x n x 3 float32, with one slider at 1 each
    masks: np.ndarray | None  # k x n float64, how much each shape counts at each vertex; None where all count fully
    triangles: np.ndarray  # m x 3 int32

    @cached_property
    def key(self):
        """Digest of all that a native Morpher of these shapes depends on."""
        return digest(self.rest, self.shapes, self.triangles)

    @cached_property
    def revision(self):
        """Digest of all that a mix depends on but the sliders."""
        masks = "all count" if self.masks is None else self.masks
        return digest(self.key, repr(self.sliders), masks)

    @cached_property
    def diagonal(self):
        """Of the rest shape's bounding box."""
        return float(np.linalg.norm(np.ptp(self.rest, axis=0))) if len(self.rest) else 0.0

    def weights(self, values):
        """(k + 1,) or, where a shape counts here more than there, (k + 1, n) float64, the rest shape first: they sum to
        1 at each vertex.

        values: (k,) of the sliders.
        """
        counts = np.asarray(values, np.float64)
        if self.masks is not None:
            is_needed = counts[self._is_part].any()
            counts = counts[:, None] * self.masks if is_needed else counts * self.masks[:, 0]
        return np.concatenate([[1.0 - counts.sum(axis=0)], counts])

    @cached_property
    def parts(self):
        """Numbers of the shapes, as of weights(), that do not count alike at all vertices; int32."""
        return 1 + np.flatnonzero(self._is_part).astype(np.int32)

    @cached_property
    def _is_part(self):
        if self.masks is None:
            return np.zeros(len(self.sliders), bool)
        return (self.masks != self.masks[:, :1]).any(axis=1)

    def linear(self, values):
        """n x 3 float64: the mix in straight lines, as Blender makes it."""
        rest = self.rest.astype(np.float64)
        result = rest.copy()
        for slider in np.flatnonzero(values):  # of many sliders few are moved
            offset = values[slider] * (self.shapes[slider] - rest)
            result += offset if self.masks is None else self.masks[slider][:, None] * offset
        return result

    def overlap(self, first, second):
        """Whether two sliders move a vertex in common."""
        return bool((self._moved[first] & self._moved[second]).any())

    @cached_property
    def _moved(self):
        return (self.shapes != self.rest).any(axis=2)
