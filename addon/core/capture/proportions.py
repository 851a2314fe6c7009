# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies whose legs are a larger or smaller share of them than those of grown-ups: markers at the heights of such."""

import numpy as np

from .landmarks import side_of

#: Height of the crotch of grown-ups over that of the body (Drillis and Contini 1966), and from what difference on a
#: mesh is another kind of body; twice the standard deviation among people.
CROTCH, UNUSUAL = 0.465, 0.03
#: Where to look for it, over the body's height: between, so near to the middle, on skin that looks down so steeply.
BETWEEN, NEAR, DOWN, LEAST = (0.2, 0.7), 0.012, -0.3, 5
ARM = ("upper_arm", "elbow", "forearm", "wrist", "hand")


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


def with_heights_of(markers, landmarks, points, normals):
    """(m, 3): markers (m, 3), aligned by the whole height, raised or lowered to where a body with such legs has them.

    Below and above the crotch heights are stretched, each in one piece; arms go along with their shoulder. Bodies of
    usual proportions, and those whose crotch is not found, leave the markers as they are. landmarks  m names or None.
    points, normals  (n, 3) samples of the mesh.
    """
    crotch = crotch_of(points, normals)
    if crotch is None or abs(crotch - CROTCH) < UNUSUAL:
        return markers
    ground, height = points[:, 2].min(), np.ptp(points[:, 2])
    above = (markers[:, 2] - ground) / height
    moved = above + np.where(
        above < CROTCH, above / CROTCH * (crotch - CROTCH), (1.0 - above) / (1.0 - CROTCH) * (crotch - CROTCH)
    )
    result = markers.copy()
    result[:, 2] = ground + height * moved
    for side in "LR":
        on_side = [k for k, name in enumerate(landmarks) if side_of(name) == side and not np.isnan(markers[k, 2])]
        shoulder, arm = ([k for k in on_side if landmarks[k].split(".")[0] in names] for names in (("shoulder",), ARM))
        if shoulder and arm:
            result[arm, 2] = markers[arm, 2] + (result - markers)[shoulder, 2].mean()
    return result
