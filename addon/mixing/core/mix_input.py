# SPDX-License-Identifier: GPL-3.0-or-later
"""The shapes that are mixed, and what their sliders mean."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...scene.core import point_sets, whole_mesh
from ...scene.core.key_shapes import KeyShapes
from ...solver.core.fingerprint import digest


@dataclass(frozen=True, eq=False)
class MixInput(KeyShapes):
    """The KeyShapes of k sliders, all relative to the rest shape, and the mesh's triangles, m x 3 int32. copies: n int
    as of scene/kept.py, of what stays together in all shapes; planes, twins: as of mirrors.seams(); None for none."""

    triangles: np.ndarray = None
    copies: np.ndarray = None
    planes: np.ndarray = None
    twins: np.ndarray = None

    @cached_property
    def key(self):
        """Digest of all that a native Morpher of these shapes depends on."""
        shapes = (self.points[name] for name in self.names)
        return digest(self.rest, *shapes, self.triangles, self.copies, self.planes, self.twins)

    @cached_property
    def whole(self):
        """What of the mesh goes to the solver."""
        return whole_mesh.of(self.rest, self.copies, self.planes, self.twins)

    @cached_property
    def revision(self):
        """Digest of all that a mix depends on but the sliders' values."""
        return digest(self.key, repr(self.sliders), *self.masks.values())

    @cached_property
    def diagonal(self):
        """Of the rest shape's bounding box."""
        return point_sets.bounding_box_diagonal(self.rest)

    def weights(self, values):
        """(k + 1,) or, where a shape counts here more than there, (k + 1, n) float64, the rest shape first: they sum to
        1 at each vertex. values: (k,) of the sliders."""
        counts = np.asarray(values, np.float64)
        if self.masks:
            is_needed = counts[self._is_part].any()
            counts = counts[:, None] * self._counts if is_needed else counts * self._counts[:, 0]
        return np.concatenate([[1.0 - counts.sum(axis=0)], counts])

    @cached_property
    def parts(self):
        """Numbers of the shapes, as of weights(), that do not count alike at all vertices; int32."""
        return 1 + np.flatnonzero(self._is_part).astype(np.int32)

    @cached_property
    def _is_part(self):
        if not self.masks:
            return np.zeros(len(self.sliders), bool)
        return (self._counts != self._counts[:, :1]).any(axis=1)

    @cached_property
    def _counts(self):
        """k x n float64: how much each shape counts at each vertex."""
        full = np.ones(len(self.rest))
        return np.array([self.masks.get(slider.group, full) for slider in self.sliders])

    def common(self, sliders):
        """How far all of some sliders (numbers) move one and the same vertex at least."""
        return float(self._moves[list(sliders)].min(axis=0).max(initial=0.0))

    @cached_property
    def _moves(self):
        """(k, n) float32: how far the sliders at 1 move the vertices."""
        return np.array([np.linalg.norm(self.points[name] - self.rest, axis=1) for name in self.names])
