# SPDX-License-Identifier: GPL-3.0-or-later
"""The upright body that markers are laid on, as points spread over it."""

import numpy as np

from ...scene.core.surface import outward
from .medial import medial_points

SAMPLES = 12000


class Body:
    """An upright mesh, +Z up.

    surface  its Surface; skin, normals  (s, 3) samples of it with the unit normals, outward; points  (s, 3): the skin
    or, for the joints of a skeleton, the middle below it; ground, height  of the mesh; above  (s,) height of the skin
    over the ground as a share of the whole.
    """

    def __init__(self, surface, is_for_joints=False, count=SAMPLES):
        self.surface, self.is_for_joints = surface, is_for_joints
        self.skin, normals = surface.samples(count)
        self.normals = outward(self.skin, normals)
        self.points = medial_points(self.skin, self.normals) if is_for_joints else self.skin
        heights = surface.vertices[np.unique(surface.triangles), 2]
        self.ground, self.height = float(heights.min()), float(np.ptp(heights))
        self.above = (self.skin[:, 2] - self.ground) / max(self.height, 1e-300)
