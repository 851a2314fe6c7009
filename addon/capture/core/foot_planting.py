# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a retargeted body is in the room: its root's path, and feet that do not slide."""

import itertools

import numpy as np

from ...scene.core.sample_times import runs
from . import landmarks as places
from .gaps import distance_variation
from .stances import ROLLING, find_stances

#: Shares of the body's height: how low markers of feet are, and how much their distances vary.
LOWEST, RIGID = 0.08, 0.01
#: Markers higher than this share of the body's height do not follow a foot.
LEGS = 0.5


def planted(shape, root, markers, reference, character, landmarks, rate, graph):
    """(f, m, 3): `shape`, each frame put where it belongs.

    The root goes the captured way, scaled: up and down by the height of the root over the ground in character and
    reference; sideways by what makes the standing feet slide least (a number for the whole take, so that a path that
    ends where it began still does). What each foot then still slides is taken away while it stands: it moves as the
    captured one does, its height over what it stands on is as captured, and stairs are scaled as the path. Between two
    stances its correction is a cubic with the speeds of both. The mean of both feet's corrections moves the root, the
    rest fades from the foot to the pelvis along the leg (harmonic on the graph): smooth in time, and knees hardly turn.

    shape  (f, m, 3) about the mean of `root` (indices); markers  (f, m, 3) the capture, without NaN; reference,
    character  (m, 3); landmarks  m names or None; graph  `MarkerGraph`.
    """
    feet = find_feet(reference, markers, landmarks)
    ground = [number for numbers in feet for number in numbers] or slice(None)
    path = markers[:, root].mean(axis=1) - reference[root].mean(axis=0)
    sizes = [np.linalg.norm(np.ptp(points, axis=0)) for points in (character, reference)]
    heights = [points[root, 2].mean() - points[ground, 2].min() for points in (character, reference)]
    ratio = heights[0] / heights[1] if min(heights) > 0.1 * min(sizes) else sizes[0] / max(sizes[1], 1e-12)
    body_height = np.ptp(reference[:, 2])
    stands = []
    if feet:
        all_stand = np.zeros(markers.shape[:2], bool)
        all_stand[:, ground] = find_stances(markers[:, ground], rate, body_height, ROLLING)
        for numbers in (numbers for numbers in feet if all_stand[:, numbers].any()):
            weights = _weights(all_stand[:, numbers], rate)
            stands.append((numbers, weights, _foot_size(character[numbers], reference[numbers])))
    sideways = _best_scale(path, shape, markers, stands, ratio)
    placed = shape + (character[root].mean(axis=0) + path * [sideways, sideways, ratio])[:, None]
    if not stands:
        return placed
    corrections = []
    for numbers, weights, size in stands:
        rises = markers[:, numbers, 2] - reference[numbers, 2]
        level = _levels(rises, weights)
        heights = character[numbers, 2] + size * (rises - level) + ratio * level
        corrections.append(_correction(placed[:, numbers], size * markers[:, numbers, :2], heights, weights))
    of_root = np.mean(corrections, axis=0)
    result = placed + of_root[:, None]
    for (numbers, _, _), correction in zip(stands, corrections, strict=True):
        share = _spread(graph, numbers, [k for foot in feet for k in foot], root, reference)
        result += share[:, None] * (correction - of_root)[:, None]
    return result


def find_feet(reference, markers, landmarks):
    """List of feet, each a list of marker numbers: heel and toes by name, or what is lowest in the reference (m, 3).

    Without names, a foot is a group of markers less than LOWEST of the body's height above the lowest one, each of
    which keeps its distance from another in markers (f, m, 3): standard deviation less than RIGID of the height.
    """
    named = [parts["heel"] + parts["toe"] for _, parts in sorted(places.feet(landmarks).items())]
    if named or np.ptp(reference[:, 2]) <= 0.0:
        return named
    height = np.ptp(reference[:, 2])
    low = np.flatnonzero(reference[:, 2] - reference[:, 2].min() < LOWEST * height)
    together = distance_variation(markers[:, low]) < RIGID * height
    left, found = set(range(len(low))), []
    while left:
        foot, front = [], [left.pop()]
        while front:
            foot.append(front.pop())
            front += sorted(left & set(np.flatnonzero(together[foot[-1]]).tolist()))
            left -= set(front)
        found.append(sorted(low[foot].tolist()))
    return sorted(found)


def _weights(on_ground, rate):
    """(f, k) 0 to 1: flags that rise and fall within a twentieth of a second, not at once; 0 where none is set."""
    half = max(1, round(0.025 * rate))
    kernel = np.hanning(2 * half + 3)[1:-1]
    padded = np.pad(on_ground.astype(float), ((half, half), (0, 0)), mode="edge")
    smooth = np.stack([np.convolve(column, kernel / kernel.sum(), mode="valid") for column in padded.T], axis=1)
    return smooth * on_ground.any(axis=1, keepdims=True)


def _levels(rises, weights):
    """(f, 1): how high what a foot stands on is over the ground of the reference, in each stance. rises  (f, k) of its
    markers."""
    result = np.zeros((len(rises), 1))
    for begin, end in runs(weights.any(axis=1)):
        result[begin:end] = np.median(rises[begin:end][weights[begin:end] > 0.0])
    return result


def _best_scale(path, shape, markers, stands, ratio):
    """The scale of the sideways path for which standing feet slide least; near `ratio`, that of the legs."""
    above = below = 0.0
    steps = np.diff(path[:, :2], axis=0)
    for numbers, weights, size in stands:
        held = np.sqrt(weights[1:] * weights[:-1])[..., None]
        slides = np.diff(shape[:, numbers, :2], axis=0) - size * np.diff(markers[:, numbers, :2], axis=0)
        above -= (held * slides * steps[:, None]).sum()
        below += (held * steps[:, None] ** 2).sum()
    # The legs' ratio counts as much as a hundredth of a body's height of way on a standing foot.
    little = 1e-4 * np.ptp(markers[0, :, 2]) ** 2
    scale = (above + little * ratio) / (below + little) if below + little > 0.0 else ratio
    return float(np.clip(scale, 0.5 * ratio, 2.0 * ratio))


def _correction(placed, paths, heights, weights):
    """(f, 3): what a foot has to be moved by. Of its k markers, where they are: placed (f, k, 3); how they should move
    on the ground: paths (f, k, 2); how high they should be: heights (f, k); how much each stands: weights (f, k)."""
    result = np.zeros((len(placed), 3))
    total = weights.sum(axis=1)
    stances = runs(total > 0.0)
    shares = weights / np.maximum(total, 1e-12)[:, None]
    result[:, 2] = (shares * (heights - placed[..., 2])).sum(axis=1)
    slides = np.diff(paths, axis=0) - np.diff(placed[..., :2], axis=0)
    slides = (0.5 * (shares[1:] + shares[:-1])[..., None] * slides).sum(axis=1)
    for begin, end in stances:
        way = np.concatenate([np.zeros((1, 2)), np.cumsum(slides[begin : end - 1], axis=0)])
        result[begin:end, :2] = way - way.mean(axis=0)
    return _bridged(result, stances)


def _foot_size(character, reference):
    """How much larger the character's foot is, by the markers farthest apart; of one marker nothing can be told."""
    sizes = [np.linalg.norm(points[:, None] - points[None], axis=2).max() for points in (character, reference)]
    return sizes[0] / sizes[1] if min(sizes) > 0.0 else 1.0


def _bridged(values, stances):
    """`values` (f, 3) kept in the stances, and between them cubics with the same places and speeds; flat outside."""
    result = values.copy()
    result[: stances[0][0]] = values[stances[0][0]]
    result[stances[-1][1] :] = values[stances[-1][1] - 1]
    for (_, begin), (end, _) in itertools.pairwise(stances):
        span = end - begin + 1
        t = np.arange(1, span)[:, None] / span
        p, q = values[begin - 1], values[end]
        u, v = (_slope(values, k, stances) * span for k in (begin - 1, end))
        result[begin:end] = p + (3 * t**2 - 2 * t**3) * (q - p) + (t**3 - 2 * t**2 + t) * u + (t**3 - t**2) * v
    return result


def _slope(values, frame, stances):
    """Mean change a frame over the few frames of the stance that begins or ends at `frame`."""
    begin, end = next((b, e) for b, e in stances if b <= frame < e)
    count = min(4, end - begin - 1)
    if count < 1:
        return np.zeros(3)
    other = frame + count if frame == begin else frame - count
    return (values[other] - values[frame]) / (other - frame)


def _spread(graph, foot, feet, root, reference):
    """(m,): how much each marker follows a foot's own correction: 1 there; 0 at other feet and above the legs; between
    them harmonic on the graph."""
    count = len(reference)
    laplacian = np.zeros((count, count))
    for first, second in graph.edges:
        laplacian[first, second] = laplacian[second, first] = -1.0
    laplacian -= np.diag(laplacian.sum(axis=1))
    free = reference[:, 2] - reference[:, 2].min() < LEGS * np.ptp(reference[:, 2])
    free[feet] = False
    if len(root) < count:
        free[root] = False
    result = np.zeros(count)
    result[foot] = 1.0
    if free.any():
        result[free] = -np.linalg.pinv(laplacian[np.ix_(free, free)]) @ laplacian[np.ix_(free, ~free)] @ result[~free]
    return result
