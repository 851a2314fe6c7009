# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies whose legs are a larger or smaller share of them than those of grown-ups: markers at the heights of such."""

from dataclasses import dataclass

import numpy as np

from .landmarks import ARM, side_of

#: Height of the crotch of grown-ups over that of the body (Drillis and Contini 1966), and from what difference on a
#: mesh is another kind of body; twice the standard deviation among people.
CROTCH, UNUSUAL = 0.465, 0.03
#: Where to look for it, over the body's height: between, so near to the middle, on skin that looks down so steeply.
BETWEEN, NEAR, DOWN, LEAST = (0.2, 0.7), 0.012, -0.3, 5


def crotch_of(points, normals):
    """Height of the crotch over that of the body, from samples of an upright body and normals (n, 3), outward; or None
    where nothing looks down between legs (skirts)."""
    above = (points[:, 2] - points[:, 2].min()) / max(np.ptp(points[:, 2]), 1e-300)
    middle = np.median(points[above > 0.5], axis=0)
    # Legs are beside each other along the axis that the upper body is wider in.
    _, _, axes = np.linalg.svd(points[above > 0.5, :2] - middle[:2], full_matrices=False)
    is_near = np.abs((points[:, :2] - middle[:2]) @ axes[0]) < NEAR * np.ptp(points[:, 2])
    found = above[is_near & (normals[:, 2] < DOWN) & (above > BETWEEN[0]) & (above < BETWEEN[1])]
    return float(np.quantile(found, 0.1)) if len(found) >= LEAST else None


@dataclass(frozen=True)
class Proportions:
    """Of an upright mesh that stands on `ground` and is `height` high: what share of that its `crotch` is at."""

    ground: float
    height: float
    crotch: float

    def of_mesh(self, markers, landmarks):
        """(m, 3): markers (m, 3), aligned by the whole height, raised or lowered to where a body with such legs has
        them.

        Below and above the crotch heights are stretched, each in one piece; arms go along with their shoulder.
        landmarks  m names or None.
        """
        return self._moved(markers, landmarks, CROTCH, self.crotch)

    def of_actor(self, markers, landmarks):
        """(m, 3): the other way round: what of_mesh() did is taken back."""
        return self._moved(markers, landmarks, self.crotch, CROTCH)

    def _moved(self, markers, landmarks, before, after):
        if before == after:
            return markers
        above = (markers[:, 2] - self.ground) / self.height
        moved = np.where(above < before, above / before * after, 1.0 - (1.0 - above) / (1.0 - before) * (1.0 - after))
        result = markers.copy()
        result[:, 2] = self.ground + self.height * moved
        for side in "LR":
            on_side = [k for k, name in enumerate(landmarks) if side_of(name) == side and not np.isnan(markers[k, 2])]
            shoulder, arm = (
                [k for k in on_side if landmarks[k].split(".")[0] in names] for names in (("shoulder",), ARM)
            )
            if shoulder and arm:
                result[arm, 2] = markers[arm, 2] + (result - markers)[shoulder, 2].mean()
        return result


def proportions_of(points, normals):
    """The Proportions of the mesh that points, normals (n, 3) are samples of; those of grown-ups where they are usual
    or the crotch is not found."""
    crotch = crotch_of(points, normals)
    if crotch is None or abs(crotch - CROTCH) < UNUSUAL:
        crotch = CROTCH
    return Proportions(float(points[:, 2].min()), float(np.ptp(points[:, 2])), crotch)
