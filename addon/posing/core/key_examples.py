# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes that a mesh is known to take, by which it is posed: its own shape keys at value 1."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...solver.core.fingerprint import digest


@dataclass(frozen=True, eq=False)
class KeyExamples:
    """Shape keys as Blender mixes them.

    keys    ((name, name of the key that it is relative to, vertex group by which it counts, or ""), ...)
    rest    n x 3 float32, the reference key
    points  {name: n x 3 float32} of the keys and of those that they are relative to
    masks   {vertex group: n float64, 0 to 1} of the groups that exist
    """

    keys: tuple
    rest: np.ndarray
    points: dict
    masks: dict

    @cached_property
    def names(self):
        """Of the keys that move anything: the others are no examples."""
        return tuple(key[0] for key in self.keys if self._offset(key).any())

    @cached_property
    def revision(self):
        """Digest of all that the examples are."""
        arrays = (*self.points.values(), *self.masks.values())
        return digest(repr(self.keys), self.rest, *arrays)

    def shapes(self):
        """The n x 3 float64 shape of each of `names`, one after the other."""
        for key in self.keys:
            if key[0] in self.names:
                yield self.rest + self._offset(key)

    def _offset(self, key):
        name, relative, group = key
        moved = self.points[name].astype(np.float64) - self.points[relative]
        mask = self.masks.get(group)
        return moved if mask is None else mask[:, None] * moved
