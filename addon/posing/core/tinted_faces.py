# SPDX-License-Identifier: GPL-3.0-or-later
"""Which part of a surface the overlay tints."""

import numpy as np


def tinted_faces(triangles, region):
    """(vertices, corners): of m x 3 triangles those whose corners all lie in the region, n bool.

    vertices: ascending indices of the vertices in use; corners: p x 3 int32, positions in `vertices`.
    """
    chosen = triangles[region[triangles].all(axis=1)]
    is_used = np.zeros(len(region), bool)
    is_used[chosen] = True
    position = np.cumsum(is_used, dtype=np.int32) - 1
    return np.flatnonzero(is_used).astype(np.int32), position[chosen]
