# SPDX-License-Identifier: GPL-3.0-or-later
"""Which points hold a mesh in place, and whether they are enough."""

import numpy as np

#: Points count as lying in one line if none is further from it than this part of their own extent.
#: Coordinates are float32 (6e-8 relative), so this is well above their noise and far below any intended triangle.
COLLINEAR_TOLERANCE = 1e-5


def bounding_box_diagonal(points):
    """Length of the diagonal of the axis-aligned box around n x 3 `points`; 0 for none."""
    if len(points) == 0:
        return 0.0
    extent = points.max(axis=0).astype(np.float64) - points.min(axis=0)
    return float(np.linalg.norm(extent))


def span_a_plane(points):
    """True if n x 3 `points` hold three that are not in one line: these fix rotation, place and size."""
    if len(points) < 3:
        return False
    offsets = points - points.mean(axis=0, dtype=np.float64)
    _, across, along = np.linalg.eigvalsh(offsets.T @ offsets)  # squared
    return bool(across > COLLINEAR_TOLERANCE**2 * along)
