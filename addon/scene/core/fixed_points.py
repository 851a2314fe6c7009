# SPDX-License-Identifier: GPL-3.0-or-later
"""Which points hold a mesh in place, and whether they are enough."""

import numpy as np

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
