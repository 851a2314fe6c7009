# SPDX-License-Identifier: GPL-3.0-or-later
"""The upright body that markers are laid on, as points spread over it, or in its middle, where the joints of skeletons
are."""

import numpy as np

SAMPLES = 12000
#: Points that balls in the middle may touch, and points that are looked at at a time.
TOUCHED, AT_ONCE = 3000, 400
#: Cosine of normals: only what looks the other way limits a ball, the next facet does not.
OPPOSITE = 0.0


class Body:
    """An upright mesh, +Z up.

    surface  its Surface; skin, normals  (s, 3) samples of it with the unit normals, outward; points  (s, 3): the skin
    or, for the joints of a skeleton, the middle below it; ground, height  of the mesh; above  (s,) height of the skin
    over the ground as a share of the whole.
    """

    def __init__(self, surface, is_for_joints=False, count=SAMPLES):
        self.surface, self.is_for_joints = surface, is_for_joints
        self.skin, normals = surface.samples(count)
        is_outward = ((self.skin - self.skin.mean(axis=0)) * normals).sum() > 0.0
        self.normals = normals if is_outward else -normals
        self.points = medial_points(self.skin, self.normals) if is_for_joints else self.skin
        heights = surface.vertices[np.unique(surface.triangles), 2]
        self.ground, self.height = float(heights.min()), float(np.ptp(heights))
        self.above = (self.skin[:, 2] - self.ground) / max(self.height, 1e-300)


def medial_points(points, normals):
    """(n, 3): for each point of a closed surface the center of the largest ball inside that touches the surface there.

    The medial axis (Blum 1967) from samples, by the ball through each point and the one that limits it most (Ma, Bae
    and Choi 2012). points (n, 3); normals (n, 3) unit, outward.
    """
    inward = -normals
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
