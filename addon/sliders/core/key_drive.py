# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles that drive shape keys: what is solved for, as arrays that belong to us."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...posing.core.bind_input import BindInput
from ...scene.core.key_shapes import KeyShapes
from ...scene.core.whole_mesh import reflection


@dataclass(frozen=True, eq=False)
class DriveInput:
    """What handles hold, and the shape keys that they drive. Each handle counts the same, however many vertices it has.
    On a symmetric mesh, their mirror images are held as well."""

    bind_input: BindInput
    shapes: KeyShapes

    @property
    def revision(self):
        return self.bind_input.revision, self.shapes.revision

    @property
    def diagonal(self):
        return self.bind_input.diagonal

    @cached_property
    def _images(self):
        """[(k bool: which anchors have an image that is no anchor itself, vertex indices of these, matrix, vector)]"""
        of = self.bind_input
        found = []
        for plane, twins in zip(of.planes, of.twins, strict=True) if of.planes is not None else ():
            twin = twins[of.anchors]
            is_seen = (twin >= 0) & ~np.isin(twin, of.anchors)
            found.append((is_seen, twin[is_seen], *reflection(plane)))
        return found

    @property
    def anchors(self):
        """K vertex indices: the handles', behind them their images."""
        return np.concatenate([self.bind_input.anchors, *(vertices for _, vertices, _, _ in self._images)])

    @property
    def handles(self):
        """K: number of the handle that each anchor, or what it mirrors, belongs to."""
        handles = self.bind_input.handles
        return np.concatenate([handles, *(handles[seen] for seen, _, _, _ in self._images)])

    def targets(self, positions):
        """(..., K, 3) targets of all anchors, made of those of the handles' anchors, (..., k, 3)."""
        images = (positions[..., seen, :] @ matrix.T + vector for seen, _, matrix, vector in self._images)
        return np.concatenate([positions, *images], axis=-2)

    def weights(self, counts=None):
        """(..., K): how much each counts; counts: (..., k), from 0 to 1, of the handles' anchors, None for all."""
        handles = self.bind_input.handles
        weights = 1.0 / np.bincount(handles)[handles]
        weights = weights if counts is None else weights * counts
        return np.concatenate([weights, *(weights[..., seen] for seen, _, _, _ in self._images)], axis=-1)

    def farthest(self, residuals):
        """(number of the handle, distance): the handle that is missed the most, by the mean of (K, 3) residuals."""
        handles = self.bind_input.handles
        distances = np.linalg.norm(residuals[: len(handles)], axis=1)
        means = np.bincount(handles, distances) / np.maximum(np.bincount(handles), 1)
        number = int(means.argmax())
        return number, float(means[number])
