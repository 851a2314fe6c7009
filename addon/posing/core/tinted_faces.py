# SPDX-License-Identifier: GPL-3.0-or-later
"""Which part of a surface the overlay tints."""

import numpy as np


def tinted_faces(triangles, face_corners, face_starts, region):
    """(vertices, corners): the triangles of the faces whose corners all lie in the region.

    triangles  m x 3 vertex indices, face after face, k - 2 for a face of k corners, as Blender has them
    face_corners, face_starts  vertex of every face corner, and where each face begins in it
    region     n bool

    vertices: ascending indices of the vertices in use; corners: p x 3 int32, positions in `vertices`.
    """
    if len(face_starts) == 0:
        return np.empty(0, np.int32), np.empty((0, 3), np.int32)
    sizes = np.diff(np.append(face_starts, len(face_corners)))
    is_inside = np.logical_and.reduceat(region[face_corners], face_starts)
    chosen = triangles[np.repeat(is_inside, sizes - 2)]
    is_used = np.zeros(len(region), bool)
    is_used[chosen] = True
    position = np.cumsum(is_used, dtype=np.int32) - 1
    return np.flatnonzero(is_used).astype(np.int32), position[chosen]
