# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a retargeted body is in the room: its root's path, and feet that do not slide."""

import itertools

import numpy as np

from ...scene.core.connected import parts
from ...scene.core.sample_times import runs
from . import landmarks as places
from .filtering import low_pass
from .gaps import distance_variation, hermite

#: Shares of the body's height: how low markers of feet are, and how much their distances vary.
LOWEST, RIGID = 0.08, 0.01
#: Body heights a second, and body heights above the ground: below both a marker stands. Feet also roll over heel or
#: toes: then they stand on some of their markers.
SLOW, LOW = 0.14, 0.05
SHORTEST = 0.06  # seconds
SMOOTHING_HZ = 12.0  # speeds of noise are no speeds


def planted(shape, root, markers, reference, character, landmarks, rate):
    """(f, m, 3): `shape`, each frame put where it belongs.

    The root goes the captured way, scaled by the height of the root over the ground in character and reference. What
    each foot then still slides is taken away while it stands: it moves and rises as the captured one does, scaled as
    the path. Between two stances its correction is a cubic. The mean of both feet's corrections moves the whole body,
    and the rest each foot.

    shape  (f, m, 3) about the mean of `root` (indices); markers  (f, m, 3) the capture, without NaN; reference,
    character  (m, 3); landmarks  m names or None.
    """
    feet = find_feet(reference, markers, landmarks)
    ground = [number for numbers in feet for number in numbers] or slice(None)
    sizes = [np.linalg.norm(np.ptp(points, axis=0)) for points in (character, reference)]
    heights = [points[root, 2].mean() - points[ground, 2].min() for points in (character, reference)]
    ratio = heights[0] / heights[1] if min(heights) > 0.1 * min(sizes) else sizes[0] / max(sizes[1], 1e-12)
    path = markers[:, root].mean(axis=1) - reference[root].mean(axis=0)
    placed = shape + (character[root].mean(axis=0) + ratio * path)[:, None]
    if not feet:
        return placed
    stands = np.zeros(markers.shape[:2], bool)
    stands[:, ground] = find_stances(markers[:, ground], rate, np.ptp(reference[:, 2]))
    corrections = []
    for foot in (numbers for numbers in feet if stands[:, numbers].any()):
        goals = ratio * markers[:, foot]
        goals[..., 2] += character[foot, 2] - ratio * reference[foot, 2]
        corrections.append((foot, _correction(placed[:, foot], goals, stands[:, foot])))
    if not corrections:
        return placed
    of_body = np.mean([correction for _, correction in corrections], axis=0)
    result = placed + of_body[:, None]
    for foot, correction in corrections:
        result[:, foot] += (correction - of_body)[:, None]
    return result


def find_feet(reference, markers, landmarks):
    """List of feet, each a list of marker numbers: heel and toes by name, or what is lowest in the reference (m, 3).

    Without names, a foot is a group of markers less than LOWEST of the body's height above the lowest one, each of
    which keeps its distance from another in markers (f, m, 3): standard deviation less than RIGID of the height.
    """
    named = list(places.feet(landmarks).values())
    if named or np.ptp(reference[:, 2]) <= 0.0:
        return named
    height = np.ptp(reference[:, 2])
    low = np.flatnonzero(reference[:, 2] - reference[:, 2].min() < LOWEST * height)
    together = distance_variation(markers[:, low]) < RIGID * height
    part = parts(np.argwhere(together), len(low))
    return [low[part == first].tolist() for first in np.unique(part)]


def find_stances(positions, rate_hz, height, slow=SLOW):
    """(f, k) bool: where each marker of a foot stands still on the ground.

    It is low and slow then, and for long enough. "Low" is above the level that it has for a fiftieth of the time, or
    above the lowest marker in that frame: so floors need not be known, and feet stand on stairs, where each is the
    lower one for part of its stance.

    positions  (f, k, 3) meters, Z up, of both feet, NaN stands nowhere; smoothed here, as noise has speed. rate_hz
    frames a second; height  of the body, meters; slow  a speed as SLOW.
    """
    smooth = low_pass(positions, rate_hz, SMOOTHING_HZ) if rate_hz > 3.0 * SMOOTHING_HZ else positions
    speed = np.linalg.norm(np.gradient(smooth, axis=0), axis=2) * rate_hz if len(smooth) > 1 else 0.0 * smooth[..., 0]
    lowest = np.fmin.reduce(smooth[..., 2], axis=1)
    result = np.zeros(positions.shape[:2], bool)
    for marker in np.flatnonzero(~np.isnan(speed).all(axis=0)):
        heights = smooth[:, marker, 2]
        ground = np.fmax(np.nanquantile(heights, 0.02), lowest)
        is_near = (speed[:, marker] < slow * height) & (heights - ground < LOW * height)
        for begin, end in runs(is_near):
            result[begin:end, marker] = end - begin >= SHORTEST * rate_hz
    return result


def _correction(placed, goals, stands):
    """(f, 3): what a foot has to be moved by. Of its k markers, where they are: placed (f, k, 3); how they should move
    on the ground, and how high they should be: goals (f, k, 3); which stand: stands (f, k) bool."""
    result = np.zeros((len(placed), 3))
    stances = runs(stands.any(axis=1))
    shares = stands / np.maximum(stands.sum(axis=1, keepdims=True), 1)
    away = goals - placed
    result[:, 2] = (shares * away[..., 2]).sum(axis=1)
    slides = (0.5 * (shares[1:] + shares[:-1])[..., None] * np.diff(away[..., :2], axis=0)).sum(axis=1)
    for begin, end in stances:
        way = np.concatenate([np.zeros((1, 2)), np.cumsum(slides[begin : end - 1], axis=0)])
        result[begin:end, :2] = way - way.mean(axis=0)
    return _bridged(result, stances)


def _bridged(values, stances):
    """`values` (f, 3) kept in the stances, and between them cubics that begin and end level; flat outside."""
    result = values.copy()
    result[: stances[0][0]] = values[stances[0][0]]
    result[stances[-1][1] :] = values[stances[-1][1] - 1]
    for before, after in itertools.pairwise(stances):
        begin, end = before[1], after[0]
        result[begin:end] = hermite(values[begin - 1], values[end], 0.0, 0.0, end - begin)
    return result
