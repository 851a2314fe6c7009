# SPDX-License-Identifier: GPL-3.0-or-later
"""Rigid and affine moves of handles, as 4 x 4 float64 matrices in the object's space; rotations fitted to
many small sets of points at once; how far poses are from each other."""

import numpy as np

IDENTITY = np.eye(4)

#: Matrices that Blender composes from float32 parts agree no better than this, relative to their size.
NOISE = 2e-6


def same(first, second):
    """True if two 4 x 4 matrices differ by no more than float32 noise."""
    scale = max(1.0, float(np.abs(first).max()), float(np.abs(second).max()))
    return bool(np.abs(first - second).max() <= NOISE * scale)


def is_flat(matrix):
    """Whether a 4 x 4 matrix squeezes space, whatever its scale."""
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    return not np.abs(np.linalg.det(matrix[:3, :3])) > 1e-9 * lengths.max(initial=0.0) ** 3


def between(rest_relation, relation):
    """The move that takes `rest_relation` to `relation`; IDENTITY where they agree but for noise. Throws
    LinAlgError."""
    if same(rest_relation, relation):
        return IDENTITY
    return relation @ np.linalg.inv(rest_relation)


def reflection(plane):
    """(3 x 3, 3 numbers): x goes to matrix x + vector. plane: unit normal and distance from the origin along it."""
    normal = np.asarray(plane[:3], np.float64)
    return np.eye(3) - 2.0 * np.outer(normal, normal), 2.0 * plane[3] * normal


#: A motion that turns, scales and moves all as one is even to this share.
EVEN = 1e-4


def in_planes(move, middle, planes):
    """Of a 4 x 4 motion of what lies around `middle`, (3,), what is the same on both sides of p x 4 planes (unit normal
    and distance, at right angles): its scale, the nearest turn that commutes with the reflections, and what moves the
    middle along them: a head that is turned aside stays as it is, and one that nods does. An uneven one as it is."""
    if move is IDENTITY or not np.isfinite(move).all():
        return move
    size = np.cbrt(np.linalg.det(move[:3, :3]))
    is_even = size != 0.0 and np.abs(move[:3, :3] @ move[:3, :3].T - size**2 * np.eye(3)).max() <= EVEN * size**2
    for plane in planes if is_even else ():
        normal, distance, (flip, _) = plane[:3], plane[3], reflection(plane)
        middle = middle - (normal @ middle - distance) * normal
        goal = apply(move, middle)
        turn = size * nearest_rotations((move[:3, :3] + flip @ move[:3, :3] @ flip) / size)
        move = affine(turn, goal - (normal @ goal - distance) * normal - turn @ middle)
    return move


def apply(move, points):
    """n x 3 float64 `points`, moved. The identity keeps their bits."""
    if move is IDENTITY:
        return points.astype(np.float64)
    return points @ move[:3, :3].T + move[:3, 3]


def fitted(before, after):
    """The rigid move that takes n x 3 points closest to others (Kabsch 1976). What they leave open (one point, a line)
    is not turned."""
    turn = fit_rotations(before, after)
    return affine(turn, after.mean(axis=0, dtype=np.float64) - turn @ before.mean(axis=0, dtype=np.float64))


def affine(linear, shift=0.0):
    """4 x 4: x goes to linear x + shift; linear 3 x 3, shift (3,)."""
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = linear, shift
    return result


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
    """(..., 3, 3): the least rotations that take directions to others (Rodrigues), (..., 3) of any length above 0; half
    a turn about any axis across."""
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


def about(axis, angles):
    """(..., 3, 3): turns about an axis (3,), of any length above 0, by angles (...) (Rodrigues)."""
    cross, angles = np.cross(np.eye(3), unit(axis)), np.asarray(angles)[..., None, None]
    return np.eye(3) + np.sin(angles) * cross + (1.0 - np.cos(angles)) * (cross @ cross)


def differing(rest, poses, most, least):
    """Numbers of the poses, at most `most`, that differ most from the rest shape and from one another, ascending.

    rest, poses  (m, 3), (f, m, 3) of a few vertices; where the whole is, and how it is turned, does not count
    least  poses nearer to each other count as the same
    """
    distances, chosen = distances_from(rest, poses), []
    while len(chosen) < most and distances.max() > least:
        chosen.append(int(distances.argmax()))
        distances = np.minimum(distances, distances_from(poses[chosen[-1]], poses))
    return sorted(chosen)


def distances_from(pose, poses):
    """(f,) float64: how far (f, m, 3) poses are from one, (m, 3), root mean square after the best rigid motion."""
    pose = pose - pose.mean(axis=0)
    poses = poses - poses.mean(axis=1, keepdims=True)
    turned = pose @ np.swapaxes(fit_rotations(pose, poses), 1, 2)
    return np.sqrt(((poses - turned) ** 2).sum(axis=2).mean(axis=1))


def placed(shape, rest, at):
    """n x 3 float64: `shape` moved, turned and scaled so that its vertices `at` come closest to those of `rest`
    (Umeyama 1991, the size by their spread). With fewer than three, or all at one place, by the whole shape."""
    shape, rest = shape.astype(np.float64), rest.astype(np.float64)
    if len(at) < 3 or np.ptp(shape[at], axis=0).max() == 0.0 or np.ptp(rest[at], axis=0).max() == 0.0:
        at = np.arange(len(rest))
    from_centre, to_centre = shape[at].mean(axis=0), rest[at].mean(axis=0)
    rotation = fit_rotations(shape[at], rest[at])
    spread = np.sqrt(((shape[at] - from_centre) ** 2).sum())
    size = np.sqrt(((rest[at] - to_centre) ** 2).sum()) / spread if spread > 0.0 else 1.0
    return size * (shape - from_centre) @ rotation.T + to_centre
