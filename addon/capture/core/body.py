# SPDX-License-Identifier: GPL-3.0-or-later
"""The upright body that markers are laid on, as points spread over it, or in its middle, where the joints of skeletons
are; and which markers of a take are on it: no prop, no other person, nothing that nobody has cleared away.

A known name vouches for a marker, unless it is far away. What has none is on the body if it goes along with it and lies
near its skin.
"""

import numpy as np

from ...scene.core.point_sets import parts
from .landmarks import unknown_limbs

SAMPLES = 12000
#: Points that balls in the middle may touch, and points that are looked at at a time.
TOUCHED, AT_ONCE = 3000, 400
#: Cosine of normals: only what looks the other way limits a ball, the next facet does not.
OPPOSITE = 0.0


class Body:
    """An upright mesh, +Z up. surface  its Surface; skin, normals  (s, 3) samples of it with the unit normals, outward;
    points  (s, 3): the skin or, for joints, the middle below it; ground, height  of the mesh; above  (s,) height of the
    skin over the ground as a share of the whole."""

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
    """(n, 3): for each point (n, 3) of a closed surface, with its unit normal (n, 3) outward, the center of the largest
    ball inside that touches it there: the medial axis (Blum 1967) from samples (Ma, Bae and Choi 2012)."""
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


#: Two markers are on one body if their distance hardly changes and is never long, over the height of all; where names
#: do not tell, one of both is enough. Of so many frames, those with the least and the most of it do not count.
LOOSE, REACH, FRAMES, MOST = 0.06, 0.45, 100, (0.05, 0.95)
#: With as many known names, these are the body; else what most markers are on.
ENOUGH = 6
#: Over the body's height, how far from the skin a marker may lie: with posed limbs, without, and with a known name.
FAR, FAR_UNPOSED, FAR_NAMED = 0.08, 0.25, 0.5


def goes_along(positions, reference, is_known):
    """(m,) bool: which markers are known, or stay together with the body.

    positions  (f, m, 3), NaN where missing; reference  (m, 3); is_known  (m,) bool.
    """
    count, height, is_named = len(reference), np.ptp(reference[:, 2]), is_known.sum() >= ENOUGH
    positions, together = positions[:: max(1, len(positions) // FRAMES)], np.logical_and if is_named else np.logical_or
    linked = np.zeros((count, count), bool)
    for marker in range(count):
        apart = np.sort(np.linalg.norm(positions - positions[:, marker, None], axis=2), axis=0)  # NaN are last
        last = np.maximum((~np.isnan(apart)).sum(axis=0) - 1, 0)
        least, most = (apart[(share * last).round().astype(int), np.arange(count)] for share in MOST)
        linked[marker] = together(most - least < LOOSE * height, most < REACH * height)
    part = parts(np.argwhere(linked), count)
    return is_known | (np.isin(part, part[is_known]) if is_named else part == np.bincount(part).argmax())


def far(distances, landmarks, is_posed):
    """Numbers of markers farther from the skin than one on it can be; none if most are: then the alignment is wrong.

    distances  (m,) over the body's height; landmarks  m names or None; is_posed: limbs are in the mesh's pose.
    """
    reach = FAR if is_posed and not unknown_limbs(landmarks) else FAR_UNPOSED
    found = [row for row, name in enumerate(landmarks) if distances[row] > (FAR_NAMED if name else reach)]
    return found if 2 * len(found) < len(landmarks) else []
