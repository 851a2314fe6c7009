# SPDX-License-Identifier: GPL-3.0-or-later
"""What is in the middle of a body: there, and not on the skin, are the joints of skeletons."""

import numpy as np

from ...scene.core.surface import outward

#: Points that balls may touch, and points that are looked at at a time.
TOUCHED, AT_ONCE = 3000, 400
#: Cosine of normals: only what looks the other way limits a ball, the next facet does not.
OPPOSITE = 0.0


def medial_points(points, normals):
    """(n, 3): for each point of a closed surface the centre of the largest ball inside that touches the surface there.

    The medial axis (Blum 1967) from samples, by the ball through each point and the one that limits it most (Ma, Bae
    and Choi 2012). points (n, 3) and normals (n, 3) unit, all outward or all inward, as `Surface.samples()` gives them.
    """
    inward = -outward(points, normals)
    some = slice(None, None, max(1, len(points) // TOUCHED))
    others, looks = points[some], inward[some]
    radii = np.empty(len(points))
    for begin in range(0, len(points), AT_ONCE):
        part = slice(begin, begin + AT_ONCE)
        squares = (points[part] ** 2).sum(axis=1)[:, None] - 2.0 * points[part] @ others.T + (others**2).sum(axis=1)
        depth = inward[part] @ others.T - (inward[part] * points[part]).sum(axis=1)[:, None]
        touches = (depth > 1e-12) & (inward[part] @ looks.T < OPPOSITE)
        radius = np.where(touches, squares / np.where(touches, 2.0 * depth, 1.0), np.inf).min(axis=1)
        radii[part] = np.where(np.isfinite(radius), radius, 0.0)
    return points + np.minimum(radii, 0.5 * np.ptp(points[:, 2]))[:, None] * inward
