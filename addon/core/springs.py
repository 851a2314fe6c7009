# SPDX-License-Identifier: GPL-3.0-or-later
"""Soft handles: springs that pull their vertices to where the handle has them."""

import numpy as np

#: Total stiffness of a soft handle of strength 0 and 1, per unit of rigidity: a slider of four decades, from hardly
#: felt to hardly giving way (measured on bars and bodies, see docs/guide.md).
WEAKEST = 1e-2
STRONGEST = 1e2

#: Stands in for a rigidity of 0, where the paper's own energy alone holds the shape.
LEAST_RIGIDITY = 1.0


def strengths(pieces, handle_strengths, rigidity):
    """k float64 for k anchors with piece numbers `pieces`; None if no handle is soft.

    handle_strengths: for each piece a slider value from 0 to 1, or None for a hard handle. A handle's spring is
    shared out among its vertices, so that a finer mesh makes it no stiffer.
    """
    if all(strength is None for strength in handle_strengths):
        return None
    result = np.full(len(pieces), np.inf)
    for number, strength in enumerate(handle_strengths):
        members = pieces == number
        if strength is not None and members.any():
            total = max(rigidity or 0.0, LEAST_RIGIDITY) * WEAKEST * (STRONGEST / WEAKEST) ** strength
            result[members] = total / np.count_nonzero(members)
    return result
