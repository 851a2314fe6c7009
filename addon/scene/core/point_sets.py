# SPDX-License-Identifier: GPL-3.0-or-later
"""Many points: whether they are numbers, how large they are, whether they hold a mesh in place, what connects them,
and what of that lies in a part of a mesh, or at its border."""

import numpy as np

from ... import wording
from ...errors import SceneError
from ...solver import native_loader

#: Of more points it is enough if about so many of them span a plane.
ENOUGH = 1000

#: Points count as lying in one line if none is further from it than this part of their own extent.
#: Coordinates are float32 (6e-8 relative), so this is well above their noise and far below any intended triangle.
COLLINEAR_TOLERANCE = 1e-5


def bounding_box_diagonal(points):
    """Length of the diagonal of the axis-aligned box around n x 3 `points`; 0 for none."""
    if len(points) == 0:
        return 0.0
    extent = [float(column.max()) - float(column.min()) for column in points.T]  # quicker by far than axis=0
    return float(np.linalg.norm(extent))


def span_a_plane(points):
    """True if n x 3 `points` hold three that are not in one line: these fix rotation, place and size."""
    if len(points) < 3:
        return False
    if len(points) > 2 * ENOUGH and span_a_plane(points[:: len(points) // ENOUGH]):
        return True
    offsets = points.astype(np.float64) - points[0].astype(np.float64)
    lengths = np.linalg.norm(offsets, axis=1)
    far = int(np.argmax(lengths))
    if lengths[far] == 0.0:
        return False
    direction = offsets[far] / lengths[far]
    beside = offsets - np.outer(offsets @ direction, direction)
    return bool(np.linalg.norm(beside, axis=1).max() > COLLINEAR_TOLERANCE * lengths[far])


def require_finite(positions, what):
    """@throws SceneError if n x 3 `positions` hold NaN or infinity."""
    broken = () if np.isfinite(positions).all() else np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if len(broken):
        count = wording.vertices(len(broken))
        raise SceneError(f"{count} of the {what} (the first is {broken[0]}) are not numbers. Move or delete them")


def parts(edges, count):
    """n int32, not to be written to: the lowest of each vertex' connected part of `count` vertices; edges m x 2."""
    nowhere, none = np.zeros((count, 3)), np.empty((0, 3), np.int32)
    return native_loader.module().SurfaceWays(nowhere, edges, none).parts


def tinted_faces(triangles, region):
    """(ascending indices of vertices, p x 3 int32 positions in these): of m x 3 triangles those whose corners all lie
    in the region, n bool."""
    chosen = triangles[region[triangles].all(axis=1)]
    is_used = np.zeros(len(region), bool)
    is_used[chosen] = True
    position = np.cumsum(is_used, dtype=np.int32) - 1
    return np.flatnonzero(is_used).astype(np.int32), position[chosen]


def border(mask, edges):
    """Ascending vertex indices where the mask, n in 0..1, passes from inside to outside: those between 0 and 1, and the
    ends of edges (m x 2) with one end inside and one outside."""
    inside = mask > 0.5
    crossing = edges[inside[edges[:, 0]] != inside[edges[:, 1]]]
    return np.union1d(np.flatnonzero((mask > 0.0) & (mask < 1.0)), crossing.ravel())
