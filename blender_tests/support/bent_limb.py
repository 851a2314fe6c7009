# SPDX-License-Identifier: GPL-3.0-or-later
"""A limb that bends and twists by formulas, so that every stage between two poses is known. Needs numpy alone."""

import numpy as np

LENGTH, RADIUS = 6.0, 0.5


def limb(around=12, along=36):
    """(n x 3 float64, [quads and the two caps]): a closed tube along X."""
    turns = 2.0 * np.pi * np.arange(around) / around
    ring = np.stack([np.zeros(around), np.cos(turns), np.sin(turns)], axis=1) * RADIUS
    places = np.linspace(0.0, LENGTH, along)
    vertices = (ring[None] + places[:, None, None] * (1.0, 0.0, 0.0)).reshape(-1, 3)
    faces = [
        (low + step, low + (step + 1) % around, low + around + (step + 1) % around, low + around + step)
        for low in range(0, around * (along - 1), around)
        for step in range(around)
    ]
    last = around * (along - 1)
    faces += [tuple(reversed(range(around))), tuple(range(last, last + around))]
    return vertices, faces


def bent(vertices, degrees):
    """The middle third bends in the plane of X and Z, as much everywhere."""
    return _carried(vertices, np.radians(degrees))


def twisted(vertices, degrees):
    """The middle third twists about X."""
    angle = np.radians(degrees) * _share(vertices[:, 0])
    cosine, sine = np.cos(angle), np.sin(angle)
    y, z = vertices[:, 1], vertices[:, 2]
    return np.stack([vertices[:, 0], cosine * y - sine * z, sine * y + cosine * z], axis=1)


def _share(x):
    return np.clip((x - LENGTH / 3.0) / (LENGTH / 3.0), 0.0, 1.0)


def _carried(vertices, angle):
    """Sections stand upright on a centre line that keeps its length, and is turned by `angle` in the end."""
    angles = angle * _share(vertices[:, 0])
    fine = np.linspace(0.0, LENGTH, 4001)
    turn = angle * _share(fine)
    line = _integrated(np.stack([np.cos(turn), np.sin(turn)], axis=1), fine[1] - fine[0])
    centre = np.stack([np.interp(vertices[:, 0], fine, line[:, axis]) for axis in (0, 1)], axis=1)
    return np.stack(
        [
            centre[:, 0] - np.sin(angles) * vertices[:, 2],
            vertices[:, 1],
            centre[:, 1] + np.cos(angles) * vertices[:, 2],
        ],
        axis=1,
    )


def _integrated(steps, width):
    """By the trapezoid rule, from 0."""
    return np.concatenate([np.zeros((1, 2)), np.cumsum(0.5 * (steps[1:] + steps[:-1]) * width, axis=0)])
