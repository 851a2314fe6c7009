# SPDX-License-Identifier: MPL-2.0
"""What the examples deform: a bar along x."""

import math

import numpy as np

RINGS, CORNERS = 30, 8


def make_bar():
    """Rings of CORNERS vertices along x, with the triangles between them; open at both ends."""
    vertices, faces = [], []
    for v in range(RINGS * CORNERS):
        ring, corner = divmod(v, CORNERS)
        angle = 2.0 * math.pi * corner / CORNERS
        vertices.append((0.2 * ring, 0.3 * math.cos(angle), 0.3 * math.sin(angle)))
        if ring + 1 < RINGS:
            beside = ring * CORNERS + (corner + 1) % CORNERS
            faces += [(v, beside, v + CORNERS), (beside, beside + CORNERS, v + CORNERS)]
    return np.array(vertices), np.array(faces)


def both_ends():
    """The vertices of the first ring, then those of the last."""
    return np.concatenate([np.arange(CORNERS), (RINGS - 1) * CORNERS + np.arange(CORNERS)])
