# SPDX-License-Identifier: GPL-3.0-or-later
"""Which part of a surface the overlay tints."""

import numpy as np


def tinted_faces(triangles, face_corners, face_starts, region, pieces=0):
    """(vertices, corners): the triangles of the faces whose corners all lie in the region.

    triangles  m x 3 vertex indices, face after face, k - 2 for a face of k corners, as Blender has them
    pieces     of a subdivided mesh: how many quads each corner of a face became, each of two triangles; else 0
    face_corners, face_starts  vertex of every face corner, and where each face begins in it
    region     n bool

    vertices: ascending indices of the vertices in use; corners: p x 3 int32, positions in `vertices`.
    """
    if len(face_starts) == 0:
        return np.empty(0, np.int32), np.empty((0, 3), np.int32)
    sizes = np.diff(np.append(face_starts, len(face_corners)))
    is_inside = np.logical_and.reduceat(region[face_corners], face_starts)
    chosen = triangles[np.repeat(is_inside, 2 * pieces * sizes if pieces else sizes - 2)]
    is_used = np.zeros(chosen.max(initial=-1) + 1, bool)
    is_used[chosen] = True
    position = np.cumsum(is_used, dtype=np.int32) - 1
    return np.flatnonzero(is_used).astype(np.int32), position[chosen]


def freedom_of_pieces(freedom, vertices, positions, quads, face_corners, face_starts):
    """How free the tinted `vertices` of a subdivided mesh are: the mean over the corners of the face that each is a
    piece of, in which nearer corners count more.

    freedom    of the mesh's own vertices, which are the first of the subdivided mesh
    positions  of all vertices, k x 3; quads  all corners of the pieces
    """
    sizes = np.diff(np.append(face_starts, len(face_corners)))
    of_each = np.repeat(np.arange(len(sizes)), len(quads) // len(face_corners) * sizes)
    is_tinted = np.logical_and.reduceat(freedom[face_corners] > 0.0, face_starts)[of_each]
    owners = np.zeros(len(positions), np.int32)
    owners[quads[is_tinted]] = of_each[is_tinted]
    owners = owners[vertices]
    counts = sizes[owners]
    firsts = np.cumsum(counts) - counts
    corners = face_corners[np.arange(counts.sum()) + np.repeat(face_starts[owners] - firsts, counts)]
    apart = ((positions[corners] - np.repeat(positions[vertices], counts, axis=0)) ** 2).sum(axis=1)
    weights = 1.0 / np.maximum(apart, 1e-9 * apart.max(initial=1e-9))
    return np.add.reduceat(weights * freedom[corners], firsts) / np.add.reduceat(weights, firsts)
