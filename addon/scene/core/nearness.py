# SPDX-License-Identifier: GPL-3.0-or-later
"""Which points are near to which, in numpy alone."""

import numpy as np

#: Of the points' extent: cells smaller than this could not be told from each other.
LEAST_CELL = 1e-12


def near_pairs(points, others, distance):
    """Yields (numbers of points, numbers of others, squared distances) of pairs at most `distance` apart.

    Others are sorted into cells of twice that: what is near enough is in one of eight.
    """
    if len(points) == 0 or len(others) == 0:
        return
    low = np.minimum(points.min(axis=0), others.min(axis=0))
    extent = np.maximum(points.max(axis=0), others.max(axis=0)) - low
    side = 2.0 * max(distance, LEAST_CELL * extent.max(), 1e-300)
    # One number for each cell. Where that overflows, distances tell apart what has the same one.
    factors = np.append(np.cumprod((extent[:0:-1] / side).astype(np.int64) + 3)[::-1], 1)
    keys = np.floor((others - low) / side).astype(np.int64) @ factors
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    lowest = np.floor((points - low) / side - 0.5).astype(np.int64) @ factors
    corners = (np.arange(8)[:, None] >> np.arange(3) & 1) @ factors
    spans = [[np.searchsorted(keys, lowest + corner, end) for end in ("left", "right")] for corner in corners]
    for begin, end in spans:
        counts = end - begin
        for step in range(int(counts.max(initial=0))):
            asking = np.flatnonzero(step < counts)
            candidates = order[begin[asking] + step]
            apart = ((points[asking] - others[candidates]) ** 2).sum(axis=1)
            is_near = apart <= distance**2
            yield asking[is_near], candidates[is_near], apart[is_near]
