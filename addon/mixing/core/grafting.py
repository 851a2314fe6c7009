# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a part of another shape belongs, so that its border meets that of the shape that it is put on."""

import numpy as np

from ...scene.core.motion import fit_rotations


def border(mask, edges):
    """Ascending vertex indices: where the mask, n in 0..1, passes over from inside to outside.

    Those between 0 and 1, and the ends of edges (m x 2) with one end inside and one outside.
    """
    inside = mask > 0.5
    crossing = edges[inside[edges[:, 0]] != inside[edges[:, 1]]]
    return np.union1d(np.flatnonzero((mask > 0.0) & (mask < 1.0)), crossing.ravel())


def placed(shape, rest, at):
    """n x 3 float64: `shape` moved, turned and scaled so that its vertices `at` come closest to those of `rest`.

    Least squares (Umeyama 1991), the size by the spread of the vertices. With fewer than three, or all at one place,
    by the whole shape.
    """
    shape, rest = shape.astype(np.float64), rest.astype(np.float64)
    if len(at) < 3 or np.ptp(shape[at], axis=0).max() == 0.0 or np.ptp(rest[at], axis=0).max() == 0.0:
        at = np.arange(len(rest))
    from_centre, to_centre = shape[at].mean(axis=0), rest[at].mean(axis=0)
    rotation = fit_rotations(shape[at], rest[at])
    spread = np.sqrt(((shape[at] - from_centre) ** 2).sum())
    size = np.sqrt(((rest[at] - to_centre) ** 2).sum()) / spread if spread > 0.0 else 1.0
    return size * (shape - from_centre) @ rotation.T + to_centre
