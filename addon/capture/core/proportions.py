# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies whose legs are a larger or smaller share of them than those of grown-ups: markers at the heights of such."""

import numpy as np

from .landmarks import ARM, side_of

#: Height of the crotch of grown-ups over that of the body (Drillis and Contini 1966), and from what difference on a
#: mesh is another kind of body; twice the standard deviation among people.
CROTCH, UNUSUAL = 0.465, 0.03
#: Where to look for it, over the body's height: between, so near to the middle, on skin that looks down so steeply.
BETWEEN, NEAR, DOWN, LEAST = (0.2, 0.7), 0.012, -0.3, 5


def crotch_of(body):
    """Height of the crotch of a Body over its own; CROTCH where that is usual or nothing looks down between legs
    (skirts)."""
    upper = body.skin[body.above > 0.5, :2]
    middle = np.median(upper, axis=0)
    # Legs are beside each other along the axis that the upper body is wider in.
    _, _, axes = np.linalg.svd(upper - middle, full_matrices=False)
    is_near = np.abs((body.skin[:, :2] - middle) @ axes[0]) < NEAR * body.height
    is_between = (body.above > BETWEEN[0]) & (body.above < BETWEEN[1])
    found = body.above[is_near & is_between & (body.normals[:, 2] < DOWN)]
    crotch = float(np.quantile(found, 0.2)) if len(found) >= LEAST else CROTCH
    return CROTCH if abs(crotch - CROTCH) < UNUSUAL else crotch


def moved(markers, landmarks, body, before, after):
    """(m, 3): markers of one whose crotch is at `before` of the height, raised or lowered to where one has them whose
    crotch is at `after`.

    Below and above the crotch heights are stretched, each in one piece; arms go along with their shoulder.
    markers  (m, 3) aligned with the Body; landmarks  m names or None.
    """
    if before == after:
        return markers
    above = (markers[:, 2] - body.ground) / body.height
    above = np.where(above < before, above / before * after, 1.0 - (1.0 - above) / (1.0 - before) * (1.0 - after))
    result = markers.copy()
    result[:, 2] = body.ground + body.height * above
    for side in "LR":
        on_side = [k for k, name in enumerate(landmarks) if side_of(name) == side]
        shoulder, arm = ([k for k in on_side if landmarks[k].split(".")[0] in names] for names in (("shoulder",), ARM))
        if shoulder and arm:
            result[arm, 2] = markers[arm, 2] + (result - markers)[shoulder, 2].mean()
    return result
