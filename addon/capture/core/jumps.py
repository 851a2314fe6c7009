# SPDX-License-Identifier: GPL-3.0-or-later
"""Markers that the capturing program took for others: paths that no body moves along."""

import collections
import itertools
import warnings

import numpy as np

from . import units

#: How far a step may be off from where the path's own speed leads: FREE of the body's extent (1 cm for an adult), and
#: USUAL times what most steps are off, in the whole take or among the NEARBY steps before and after. Takes that lost
#: single frames (of 120 Hz every sixth, say) stutter everywhere, and that is no fault of a marker.
FREE, USUAL, NEARBY = 0.008, 4.0, 20
#: Gaps of less samples are judged by speeds, longer ones by neighbors.
SHORT = 4
#: Speeds are medians of so many steps, distances of so many samples.
WINDOW = 3
#: Seconds between the reappearances of two markers that may have been swapped meanwhile.
TOGETHER = 0.5
#: The distances of a marker to PARTNERS neighbors are compared before and after a gap. AGREEING of them must differ by
#: more than they usually change within LAG samples.
PARTNERS, AGREEING, LAG = 5, 3, 10


#: Something to look at: `kind` is "jump" or "swap"; `sample` is the first wrong one, counted from 0; `other` is the
#: marker it was swapped with, or None.
Finding = collections.namedtuple("Finding", "kind marker sample words other", defaults=[None])

#: A marker's path does not go on to sample `first`: there it is at `place`, and its speed `before`, a sample, leads to
#: `expected`.
_Break = collections.namedtuple("_Break", "marker first place expected before")


def find_jumps(positions, rate_hz, labels=None, are_joints=False):
    """List of `Finding`, by sample: markers that jump, away or back, or are swapped with another.

    A path breaks where a step differs from the mean of the speeds before and after it by far more than its steps
    usually do, and by more than half of what these differ by: noise, fast motion and hard stops pass. After a gap,
    distances to the neighbors that are most rigid with the marker must be as before. Two markers whose paths break
    together and go on in each other's are swapped, unless they are nearer than twice FREE of the body's extent.

    positions  (f, m, 3) meters, NaN where missing, not filled; rate_hz  frames a second; labels  names for the words;
    are_joints  of a skeleton, as in BVH: swaps are not looked for.
    """
    names = [f"marker {number}" for number in range(positions.shape[1])] if labels is None else labels
    size = units.median_extent(positions)
    if not size > 0.0:
        return []
    breaks = [one for marker in range(positions.shape[1]) for one in _breaks(positions, marker, size)]
    findings, rest = ([], breaks) if are_joints else _swaps(breaks, rate_hz * TOGETHER, names)
    for one in rest:
        distance = 1000.0 * float(np.linalg.norm(one.place - one.expected))
        words = f"{names[one.marker]} jumps by {distance:.0f} mm at sample {one.first}"
        findings.append(Finding("jump", one.marker, one.first, words))
    return sorted(findings, key=lambda finding: (finding.sample, finding.marker))


def _breaks(positions, marker, size):
    path = positions[:, marker]
    good = np.flatnonzero(~np.isnan(path[:, 0]))
    if len(good) < 4:
        return []
    known, spans = path[good], np.diff(good)
    speeds = np.diff(known, axis=0) / spans[:, None]
    # Medians of the WINDOW speeds before and after each, of the other side where there is none.
    padded = np.pad(speeds, ((WINDOW, WINDOW), (0, 0)), constant_values=np.nan)
    medians = _median(np.stack([padded[k : len(padded) - WINDOW + 1 + k] for k in range(WINDOW)]))
    before, after = medians[: len(speeds)], medians[WINDOW + 1 :]
    before, after = np.where(np.isnan(before), after, before), np.where(np.isnan(after), before, after)
    off = np.linalg.norm(spans[:, None] * (speeds - 0.5 * (before + after)), axis=1)
    allowed = FREE * size + 0.5 * spans * np.linalg.norm(after - before, axis=1)
    single = np.where(spans == 1, off, np.nan)
    overall = np.quantile(off[spans == 1], 0.9) if (spans == 1).any() else np.inf
    for step in np.flatnonzero(off > allowed):
        near = single[max(0, step - NEARBY) : step + NEARBY + 1]
        near = near[~np.isnan(near)]
        nearby = np.quantile(near, 0.85, method="lower") if len(near) else 0.0
        allowed[step] += USUAL * max(overall, nearby) * spans[step] ** 2
    allowed[[0, -1]] *= 3.0  # at the take's ends only one side is known
    broken = (off > allowed) & (spans < SHORT)
    gaps = np.flatnonzero(spans >= SHORT)
    if len(gaps):
        broken[gaps] = _has_other_neighbours(positions, marker, good[gaps], good[gaps + 1], FREE * size)
    expected = known[:-1] + spans[:, None] * before
    return [
        _Break(marker, int(good[step + 1]), known[step + 1], expected[step], before[step])
        for step in np.flatnonzero(broken)
    ]


def _median(values):
    """The median over the first axis, without NaN; NaN where there is nothing else."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return np.nanmedian(values, axis=0)


def _has_other_neighbours(positions, marker, lasts, firsts, free):
    """(g,) bool of g gaps of a marker: whether its distances to the neighbors that are most rigid with it differ before
    the gap, until samples `lasts` (g,), and after it, from samples `firsts` (g,) on.

    Rigid are those whose distances change little within LAG samples, not over the take: after a swap that is never
    undone they all do.
    """

    def distances(frames):
        some = positions[frames]
        return np.linalg.norm(some - some[:, marker, None], axis=2)

    starts = np.arange(0, max(1, len(positions) - LAG), max(1, len(positions) // 1500))
    change = np.abs(distances(np.minimum(starts + LAG, len(positions) - 1)) - distances(starts))
    counts = (~np.isnan(change)).sum(axis=0)
    usual = np.sort(change, axis=0)[np.minimum((0.9 * counts).astype(int), len(change) - 1), np.arange(len(counts))]
    usual[(counts < LAG) | np.isnan(usual)] = np.inf
    usual[marker] = np.inf
    order = np.argsort(usual, kind="stable")[: np.count_nonzero(np.isfinite(usual))]
    result = np.zeros(len(lasts), bool)
    for gap, (last, first) in enumerate(zip(lasts, firsts, strict=True)):
        before, after = (
            _median(distances(slice(max(0, begin), begin + WINDOW))) for begin in (last + 1 - WINDOW, first)
        )
        change = np.abs(after - before)
        partners = [other for other in order if not np.isnan(change[other])][:PARTNERS]
        lags = max(1.0, (first - last) / LAG)
        result[gap] = np.sum(change[partners] > 3.0 * lags * usual[partners] + 2.0 * free) >= AGREEING
    return result


def _swaps(breaks, window, names):
    """(findings of swapped pairs, breaks that are left)."""
    candidates = []
    for (number, one), (other_number, other) in itertools.combinations(enumerate(breaks), 2):
        if one.marker == other.marker or abs(one.first - other.first) > window:
            continue
        apart = np.linalg.norm(one.place - one.expected) + np.linalg.norm(other.place - other.expected)
        crossed = np.linalg.norm(_expected_at(other, one.first) - one.place)
        crossed += np.linalg.norm(_expected_at(one, other.first) - other.place)
        if crossed < 0.4 * apart:
            candidates.append((crossed / apart, number, other_number))
    used, findings = set(), []
    for _, number, other_number in sorted(candidates):
        if number in used or other_number in used:
            continue
        used |= {number, other_number}
        one, other = breaks[number], breaks[other_number]
        sample, distance = min(one.first, other.first), float(np.linalg.norm(one.place - one.expected))
        pair = f"{names[one.marker]} and {names[other.marker]}"
        words = f"{pair}, {1000.0 * distance:.0f} mm apart, change places at sample {sample}"
        findings.append(Finding("swap", one.marker, sample, words, other.marker))
    return findings, [one for number, one in enumerate(breaks) if number not in used]


def _expected_at(one, sample):
    return one.expected + (sample - one.first) * one.before
