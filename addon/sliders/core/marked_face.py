# SPDX-License-Identifier: GPL-3.0-or-later
"""Which markers of a take tell something of a face."""

import numpy as np

#: A marker that moves less than this share of what markers usually do is stuck.
STILL = 1e-3

#: Markers farther from the surface than this share of how far they usually are from their middle are no face's.
FAR = 0.5


def still(path):
    """(m,) bool: the markers of path (f, m, 3), NaN where one is missing, that never move while most do; or all do not.

    Where most stand still, the head was held or the take was freed of its motion, and they tell so.
    """
    moves = (np.fmax.reduce(path) - np.fmin.reduce(path)).max(axis=1)
    moves = np.where(np.isnan(moves), 0.0, moves)
    usual = np.median(moves)
    return moves <= STILL * usual if usual > 0.0 else np.full(len(moves), not moves.any())


def far(places, distance):
    """(m,) bool: the markers at places (m, 3) whose distance (m,) from the surface is too large to be of the face."""
    spread = np.median(np.linalg.norm(places - np.median(places, axis=0), axis=1))
    return distance > FAR * spread
