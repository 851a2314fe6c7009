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
    """(..., 3, 3) -> (..., 3, 3): the rotations R with the greatest tr(R^T M).

    That greatest value l (the sum of the singular values, the last one with the sign of det M) is the largest root of
    l^4 - 2 |M|^2 l^2 - 8 det(M) l + 2 |M^T M|^2 - |M|^4 (Horn 1987), found by Newton's method from above. With
    s = (l^2 - |M|^2) / 2, by Cayley and Hamilton, R = ((l^2 - s) M + l cof(M) - M M^T M) / (l s - det M). Where the
    divisor, the product of the sums of two singular values, is next to nothing: singular value decomposition, which is
    twenty times slower.
    """
    matrices = np.asarray(matrices, float)
    size = np.sqrt((matrices**2).sum(axis=(-1, -2), keepdims=True))
    m = matrices / np.where(size > 1e-300, size, 1.0)
    # Rows of cofactors are cross products of the other two; numpy's own is slow on few.
    second, third = m[..., [1, 2, 0], :], m[..., [2, 0, 1], :]
    cofactors = second[..., [1, 2, 0]] * third[..., [2, 0, 1]] - second[..., [2, 0, 1]] * third[..., [1, 2, 0]]
    determinant = (m[..., 0, :] * cofactors[..., 0, :]).sum(axis=-1)
    square = np.swapaxes(m, -1, -2) @ m
    constant = 2.0 * (square**2).sum(axis=(-1, -2)) - 1.0
    root = np.full(determinant.shape, np.sqrt(3.0))
    for _ in range(24):
        value = ((root**2 - 2.0) * root - 8.0 * determinant) * root + constant
        slope = 4.0 * (root**2 - 1.0) * root - 8.0 * determinant
        step = np.where(slope > 1e-12, value / np.where(slope > 1e-12, slope, 1.0), 0.0)
        root = root - step
        if np.abs(step).max(initial=0.0) < 1e-14:
            break
    half = 0.5 * (root**2 - 1.0)
    divisor = root * half - determinant
    is_clear = (divisor > 1e-4) & (size[..., 0, 0] > 1e-300)
    weights = [x[..., None, None] for x in (root**2 - half, root, np.where(is_clear, divisor, 1.0))]
    result = (weights[0] * m + weights[1] * cofactors - m @ square) / weights[2]
    if not is_clear.all():
        result[~is_clear] = _nearest_by_singular_values(m[~is_clear])
    return result


def _nearest_by_singular_values(matrices):
    left, _, right = np.linalg.svd(matrices)
    signs = np.ones(matrices.shape[:-1])
    signs[..., 2] = np.where(np.linalg.det(left) * np.linalg.det(right) < 0.0, -1.0, 1.0)
    return (left * signs[..., None, :]) @ right


def turns_between(before, after):
    """(..., 3, 3): the least rotations that take directions to others (Rodrigues); half a turn about any axis across.

    before, after  (..., 3), of any length above 0.
    """
    before = before / np.maximum(np.linalg.norm(before, axis=-1, keepdims=True), 1e-300)
    after = after / np.maximum(np.linalg.norm(after, axis=-1, keepdims=True), 1e-300)
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
