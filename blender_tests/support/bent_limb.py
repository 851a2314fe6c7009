# SPDX-License-Identifier: GPL-3.0-or-later
"""A limb that bends and twists by formulas, so that every stage between two poses is known. Needs numpy alone."""

import numpy as np

from . import rings

LENGTH, RADIUS = 6.0, 0.5


def limb(around=12, along=36):
    """(n x 3 float64, [quads and the two caps]): a closed tube along X."""
    turns = 2.0 * np.pi * np.arange(around) / around
    ring = np.stack([np.zeros(around), np.cos(turns), np.sin(turns)], axis=1) * RADIUS
    places = np.linspace(0.0, LENGTH, along)
    vertices = (ring[None] + places[:, None, None] * (1.0, 0.0, 0.0)).reshape(-1, 3)
    last = around * (along - 1)
    caps = [tuple(reversed(range(around))), tuple(range(last, last + around))]
    return vertices, [*map(tuple, rings.quads(along, around).tolist()), *caps]


def bent(vertices, degrees):
    """The middle third bends in the plane of X and Z, as much everywhere, and keeps its length."""
    angle = np.radians(degrees)
    if angle == 0.0:
        return vertices.copy()
    x, y, z = vertices.T
    turned, radius = angle * _share(x), LENGTH / 3.0 / angle
    before, behind = np.minimum(x, LENGTH / 3.0), np.maximum(x - 2.0 * LENGTH / 3.0, 0.0)
    along = before + radius * np.sin(turned) + behind * np.cos(angle)
    up = radius * (1.0 - np.cos(turned)) + behind * np.sin(angle)
    return np.stack([along - z * np.sin(turned), y, up + z * np.cos(turned)], axis=1)


def twisted(vertices, degrees):
    """The middle third twists about X."""
    angle = np.radians(degrees) * _share(vertices[:, 0])
    cosine, sine = np.cos(angle), np.sin(angle)
    y, z = vertices[:, 1], vertices[:, 2]
    return np.stack([vertices[:, 0], cosine * y - sine * z, sine * y + cosine * z], axis=1)


def _share(x):
    return np.clip((x - LENGTH / 3.0) / (LENGTH / 3.0), 0.0, 1.0)
