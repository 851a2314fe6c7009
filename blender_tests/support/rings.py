# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces of tubes and balls: of rings of vertices, one after the other. Needs numpy alone."""

import numpy as np


def quads(rings, around, first=0):
    """(q, 4) between rings of `around` vertices, from number `first` on; outward where they go round and up."""
    here = first + np.arange(rings * around).reshape(rings, around)
    after = np.roll(here, -1, axis=1)
    return np.stack([here[:-1], after[:-1], after[1:], here[1:]], axis=-1).reshape(-1, 4)


def fan(pole, ring):
    """(k, 3) triangles from a vertex to the edges of a ring around it."""
    return np.stack([np.full(len(ring), pole), ring, np.roll(ring, -1)], axis=1)


def triangles(faces):
    """(2 q, 3) int32 of the quads (q, 4)."""
    return np.stack([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]], axis=1).reshape(-1, 3).astype(np.int32)
