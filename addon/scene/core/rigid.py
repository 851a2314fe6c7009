# SPDX-License-Identifier: GPL-3.0-or-later
"""Rotations fitted to many small sets of points at once."""

import numpy as np

#: How much a prior rotation counts beside the points themselves: enough to settle a turn that they leave open (one
#: point, a line with some noise), too little to be seen otherwise. Without one only exact ties are settled.
PRIOR, TIE = 1e-3, 1e-9


def fit_rotations(source, target, weights=None, prior=None, strength=PRIOR):
    """(..., 3, 3) float64: the rotations R that take sets of points closest to others (Kabsch 1976).

    Least sum of w |R (s - mean s) - (t - mean t)|^2, with det R = 1.

    source, target  (..., k, 3), broadcast against each other; points with NaN in either do not count.
    weights  (..., k) >= 0, broadcast, or None: all alike.
    prior  (..., 3, 3) rotations that settle what the points leave open, or None: then that part is not turned.
    strength  how much the prior counts, where the points count 1.

    Never raises for poor sets: without two points the answer is the prior.
    """
    source, target = np.broadcast_arrays(np.asarray(source, float), np.asarray(target, float))
    counts = ~(np.isnan(source[..., 0]) | np.isnan(target[..., 0]))
    weights = counts * (1.0 if weights is None else weights)
    source = np.where(counts[..., None], source, 0.0)
    target = np.where(counts[..., None], target, 0.0)
    share = weights / np.maximum(weights.sum(axis=-1, keepdims=True), 1e-300)
    source = source - (share[..., None] * source).sum(axis=-2, keepdims=True)
    target = target - (share[..., None] * target).sum(axis=-2, keepdims=True)
    correlation = np.swapaxes(target * share[..., None], -1, -2) @ source
    size = np.sqrt((correlation**2).sum(axis=(-1, -2)))[..., None, None]
    settled = TIE * np.eye(3) if prior is None else strength * prior
    return nearest_rotations(correlation / np.where(size > 1e-30, size, 1.0) + settled)


def nearest_rotations(matrices):
    """(..., 3, 3) -> (..., 3, 3): the rotations R with the greatest tr(R^T M)."""
    left, _, right = np.linalg.svd(matrices)
    left[..., 2] *= np.where(np.linalg.det(left @ right) < 0.0, -1.0, 1.0)[..., None]
    return left @ right


def unit(vectors):
    """(..., 3), each 1 long; 0 stays 0."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300)


def turns_between(before, after):
    """(..., 3, 3): the least rotations that take directions to others (Rodrigues); half a turn about any axis across.

    before, after  (..., 3), of any length above 0.
    """
    before, after = unit(before), unit(after)
    cosine = (before * after).sum(axis=-1)
    axis = np.cross(before, after)
    cross = np.zeros((*axis.shape, 3))
    for row, column, component, sign in ((0, 1, 2, -1), (0, 2, 1, 1), (1, 2, 0, -1)):
        cross[..., row, column] = sign * axis[..., component]
        cross[..., column, row] = -sign * axis[..., component]
    result = np.eye(3) + cross + cross @ cross / np.maximum(1.0 + cosine, 1e-9)[..., None, None]
    opposite = cosine < -1.0 + 1e-9
    if opposite.any():
        least = np.eye(3)[np.abs(before[opposite]).argmin(axis=-1)]
        across = np.cross(before[opposite], least)
        across /= np.linalg.norm(across, axis=-1, keepdims=True)
        result[opposite] = 2.0 * across[..., :, None] * across[..., None, :] - np.eye(3)
    return result
