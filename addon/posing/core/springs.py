# SPDX-License-Identifier: GPL-3.0-or-later
"""Springs: soft handles pull their vertices to where the handle has them, a soft border to the rest shape."""

import numpy as np

#: Stiffness of a soft handle of strength 0 and 1, per unit of rigidity and share of the mesh: a slider of four
#: decades, from hardly felt to hardly giving way. The energy of a shape falls as its mesh gets finer (the squared
#: edge length is its unit), and so must the springs.
WEAKEST = 4e-3
STRONGEST = 4e1

#: The same of a region's soft border, where the weight is a half: as stiff as the shape itself is over the size of the
#: region. A handle in the middle of a flat disk that fades out to its edge takes what has half the weight 0.43 times as
#: far along as it goes itself; with 10 for 1 it is 0.31 times, without springs 0.46 times.
BORDER = 1.0

#: Stands in for a rigidity of 0, where the paper's own energy alone holds the shape.
LEAST_RIGIDITY = 1.0


def strengths(handles, handle_strengths, rigidity, vertex_count):
    """k float64 for k anchors with handle numbers `handles`; None if no handle is soft.

    handle_strengths: of each handle 0 to 1, None if it is hard: its spring is shared out among its vertices, so that a
    finer mesh makes it no stiffer. vertex_count: those that may move.
    """
    if all(strength is None for strength in handle_strengths):
        return None
    result = np.full(len(handles), np.inf)
    for number, strength in enumerate(handle_strengths):
        members = handles == number
        if strength is not None and members.any():
            total = max(rigidity or 0.0, LEAST_RIGIDITY) * WEAKEST * (STRONGEST / WEAKEST) ** strength
            result[members] = total / (vertex_count * np.count_nonzero(members))
    return result


def border_strengths(weights, rigidity, vertex_count):
    """b float64 from b region weights w between 0 and 1, both left out: free near 1, held to the rest shape near 0.
    vertex_count: those that may move, n. With K of handles shared out over these, s = K (1 - w)/(w n^2)."""
    return max(rigidity or 0.0, LEAST_RIGIDITY) * BORDER * (1.0 - weights) / (weights * float(vertex_count) ** 2)
