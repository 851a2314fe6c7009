# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a retargeted body is in the room: its root's path, and feet that do not slide."""

import numpy as np

from . import landmarks as places
from .gaps import runs
from .stances import ROLLING, find_stances


def planted(shape, root, markers, reference, character, landmarks, rate, graph, plant_feet=True):
    """(f, m, 3): `shape`, each frame put where it belongs.

    The root goes the captured way, scaled: up and down by the height of the root over the ground in character and
    reference; sideways by what makes the standing feet slide least (a number for the whole take, so that a path that
    ends where it began still does). What each foot then still slides is taken away while it stands: it moves as the
    captured one does, its height over the ground is as captured. Between two stances its correction is a cubic with
    the speeds of both. The mean of both feet's corrections moves the root, the rest fades from the foot to the pelvis
    along the leg (harmonic on the graph): smooth in time, and knees hardly turn.

    shape  (f, m, 3) about the mean of `root` (indices); markers  (f, m, 3) the capture, without NaN; reference,
    character  (m, 3); landmarks  m names or None; graph  `MarkerGraph`.
    """
    feet = places.feet(landmarks)
    ground = [number for foot in feet.values() for numbers in foot.values() for number in numbers] or None
    path = markers[:, root].mean(axis=1) - reference[root].mean(axis=0)
    heights = [points[root, 2].mean() - points[ground, 2].min() for points in (character, reference)] if ground else [0, 0]
    sizes = [np.linalg.norm(np.ptp(points, axis=0)) for points in (character, reference)]
    ratio = heights[0] / heights[1] if min(heights) > 0.1 * min(sizes) else sizes[0] / max(sizes[1], 1e-12)
    body_height = np.ptp(reference[:, 2])
    stands = {}
    for side, parts in feet.items() if plant_feet and body_height > 0.0 else ():
        numbers = parts["heel"] + parts["toe"]
        on_ground = find_stances(markers[:, numbers], rate, body_height, ROLLING)
        if on_ground.any():
            stands[side] = (numbers, _weights(on_ground, rate))
    sideways = _best_scale(path, shape, markers, stands, ratio)
    placed = shape + (character[root].mean(axis=0) + path * [sideways, sideways, ratio])[:, None]
    if not stands:
        return placed
    corrections = {
        side: _correction(placed[:, numbers], markers[:, numbers], character[numbers], reference[numbers], weights)
        for side, (numbers, weights) in stands.items()
    }
    of_root = np.mean(list(corrections.values()), axis=0)
    spread = _spread(graph, landmarks, {side: numbers for side, (numbers, _) in stands.items()}, len(reference))
    result = placed + of_root[:, None]
    for side, correction in corrections.items():
        result += spread[side][:, None] * (correction - of_root)[:, None]
    return result


def _weights(on_ground, rate):
    """(f, k) 0 to 1: flags that rise and fall within a twentieth of a second instead of at once; 0 where none is set."""
    half = max(1, round(0.025 * rate))
    kernel = np.hanning(2 * half + 3)[1:-1]
    padded = np.pad(on_ground.astype(float), ((half, half), (0, 0)), mode="edge")
    smooth = np.stack([np.convolve(column, kernel / kernel.sum(), mode="valid") for column in padded.T], axis=1)
    return smooth * on_ground.any(axis=1, keepdims=True)


def _best_scale(path, shape, markers, stands, ratio):
    """The scale of the sideways path for which standing feet slide least; near `ratio`, that of the legs."""
    above = below = 0.0
    steps = np.diff(path[:, :2], axis=0)
    for numbers, weights in stands.values():
        held = np.sqrt(weights[1:] * weights[:-1])[..., None]
        slides = np.diff(shape[:, numbers, :2], axis=0) - np.diff(markers[:, numbers, :2], axis=0)
        above -= (held * slides * steps[:, None]).sum()
        below += (held * steps[:, None] ** 2).sum()
    # The legs' ratio counts as much as a hundredth of a body's height of way on a standing foot.
    little = 1e-4 * np.ptp(markers[0, :, 2]) ** 2
    scale = (above + little * ratio) / (below + little) if below + little > 0.0 else ratio
    return float(np.clip(scale, 0.5 * ratio, 2.0 * ratio))


def _correction(placed, markers, character, reference, weights):
    """(f, 3): what a foot has to be moved by. Its markers: placed, markers (f, k, 3), character, reference (k, 3)."""
    result = np.zeros((len(placed), 3))
    total = weights.sum(axis=1)
    stances = runs(total > 0.0)
    shares = weights / np.maximum(total, 1e-12)[:, None]
    size = _foot_size(character) / max(_foot_size(reference), 1e-12) if len(character) > 1 else 1.0
    heights = character[:, 2] + size * (markers[..., 2] - reference[:, 2])
    result[:, 2] = (shares * (heights - placed[..., 2])).sum(axis=1)
    slides = size * np.diff(markers[..., :2], axis=0) - np.diff(placed[..., :2], axis=0)
    slides = (0.5 * (shares[1:] + shares[:-1])[..., None] * slides).sum(axis=1)
    for begin, end in stances:
        way = np.concatenate([np.zeros((1, 2)), np.cumsum(slides[begin : end - 1], axis=0)])
        result[begin:end, :2] = way - way.mean(axis=0)
    return _bridged(result, stances)


def _foot_size(points):
    return np.linalg.norm(points[:, None] - points[None], axis=2).max()


def _bridged(values, stances):
    """`values` (f, 3) kept within the stances, and between them cubics with the same places and speeds; flat outside."""
    result = values.copy()
    result[: stances[0][0]] = values[stances[0][0]]
    result[stances[-1][1] :] = values[stances[-1][1] - 1]
    for (_, begin), (end, _) in zip(stances[:-1], stances[1:], strict=True):
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


def _spread(graph, landmarks, feet, count):
    """side -> (m,): how much each marker follows a foot's own correction: 1 there, 0 above the hips, harmonic between."""
    legs = {f"{part}.{side}" for part in ("thigh", "shank", "foot") for side in "LR"}
    laplacian = np.zeros((count, count))
    for first, second in graph.edges:
        laplacian[first, second] = laplacian[second, first] = -1.0
    laplacian -= np.diag(laplacian.sum(axis=1))
    segments = [set(places.segments_of(landmark)) for landmark in landmarks]
    result = {}
    for side in feet:
        foot = np.array([f"foot.{side}" in names for names in segments])
        free = np.array([bool(names & legs) and "pelvis" not in names for names in segments])
        free &= np.array([any(name.endswith(f".{side}") for name in names) for names in segments]) & ~foot
        values = foot.astype(float)
        if free.any():
            values[free] = -np.linalg.pinv(laplacian[np.ix_(free, free)]) @ laplacian[np.ix_(free, foot)].sum(axis=1)
        result[side] = values
    return result
