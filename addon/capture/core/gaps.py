# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples that no camera saw: found, and filled where what is known around them tells enough."""

from dataclasses import dataclass

import numpy as np

from ...scene.core import checks
from ...scene.core.rigid import fit_rotations
from ...scene.core.sample_times import runs

MEASURED, SPLINE, RIGID, MISSING = 0, 1, 2, 3

#: Samples at the first and last frame that a spline may be carried on by: it knows only one side there.
MOST_BEYOND = 3
#: Good samples beside a gap that its slope is read from.
SLOPE_SAMPLES = 5
#: Neighbours that carry a marker through a gap.
MOST_NEIGHBOURS = 6
#: Metres that the distances of a gap's neighbours may vary by: the best first, and none worse than the last.
VARIATIONS = (0.01, 0.03, 0.1)
#: Metres that no difference in variation is made of.
NOISE = 0.001
#: Neighbours are weighted by these powers of how little their distances vary, one after the other: each settles the
#: turn that the next leaves open, where few count and lie on a line. A segment with three markers needs no others;
#: where it has two those of the next one must count for little, but not for nothing.
POWERS, PRIOR = (1, 3), 0.05
#: A neighbour's distance may vary by this share of it (standard deviation), or it is no neighbour.
LARGEST_VARIATION = 0.2
#: Frames in which two markers must be seen together before anything is said of their distance.
LEAST_TOGETHER = 10


@dataclass(frozen=True)
class Gap:
    """Samples `begin` to `end` - 1 of a marker are missing."""

    marker: int
    begin: int
    end: int

    @property
    def length(self):
        return self.end - self.begin


def find_gaps(positions):
    """List of `Gap` in (f, m, 3) positions, by marker and then by frame. A marker that is never seen is one gap."""
    missing = np.isnan(checks.motion(positions)[..., 0])
    return [Gap(marker, int(b), int(e)) for marker in range(missing.shape[1]) for b, e in runs(missing[:, marker])]


def fill_gaps(positions, longest_spline=10, longest_rigid=200):
    """(filled (f, m, 3) float64, how (f, m) uint8: MEASURED 0, SPLINE 1, RIGID 2, MISSING 3).

    positions  (f, m, 3), NaN where a sample is missing. Measured samples keep their bits.
    longest_spline  in samples: gaps up to that long are cubics, with place and slope of the good samples on both sides
        (the slope of a parabola fitted to the nearest five). At the take's first and last frames, where one side is
        unknown, a straight line goes on for at most MOST_BEYOND samples.
    longest_rigid  in samples: longer gaps, up to that, move rigidly with those neighbours whose distances to the
        marker vary least, as far as they are seen (or filled by a spline); what differs at the far end is faded in, so
        that the path is continuous with what was measured. Also short ones at the take's ends.
    Still longer gaps, and those with less than three usable neighbours, stay NaN.

    Filling by the rigid motion of neighbours is usual practice (Aristidou and Lasenby 2013 predict markers so); that
    both ends are met is ours. Raises InvalidMotionError for wrong shapes and negative lengths.
    """
    measured = checks.motion(positions)
    for length, filler in ((longest_spline, "splines"), (longest_rigid, "neighbors")):
        if not length >= 0:
            raise checks.InvalidMotionError(f"The longest gap for {filler} is {length} samples, but must be 0 or more.")
    filled = measured.copy()
    how = np.where(np.isnan(measured[..., 0]), MISSING, MEASURED).astype(np.uint8)
    gaps = find_gaps(measured)
    for gap in gaps:
        if gap.length <= longest_spline and _fill_by_spline(measured, filled, gap):
            how[gap.begin : gap.end, gap.marker] = SPLINE
    variation = distance_variation(measured)
    _fill_rigidly(filled, how, [gap for gap in gaps if gap.length <= longest_rigid], variation)
    return filled, how


def distance_variation(positions):
    """(m, m) metres: standard deviation of the distance of markers i and j over the frames where both are seen.

    Infinite on the diagonal, where it is more than LARGEST_VARIATION of the mean distance, and where they are seen
    together in less than LEAST_TOGETHER frames. Of long takes, some frames are looked at. positions (f, m, 3).
    """
    positions = positions[:: max(1, len(positions) // 2000)]
    seen = ~np.isnan(positions[..., 0])
    result = np.full((positions.shape[1],) * 2, np.inf)
    points = np.where(seen[..., None], positions, 0.0)
    for marker in range(positions.shape[1]):
        together = seen & seen[:, marker, None]
        count = together.sum(axis=0)
        distances = np.linalg.norm(points - points[:, marker, None], axis=2) * together
        mean = distances.sum(axis=0) / np.maximum(count, 1)
        variance = ((distances - mean) ** 2 * together).sum(axis=0) / np.maximum(count, 1)
        enough = count >= min(LEAST_TOGETHER, max(2, len(positions) // 2))
        is_neighbour = enough & (variance < (LARGEST_VARIATION * mean) ** 2)
        result[marker, is_neighbour] = np.sqrt(variance[is_neighbour])
    np.fill_diagonal(result, np.inf)
    return result


def _fill_by_spline(measured, filled, gap):
    """True if the gap was filled: by a cubic between its ends, or by a few samples of a line beyond the take's."""
    path = measured[:, gap.marker]
    is_inside = gap.begin > 0 and gap.end < len(path)
    if gap.length == len(path) or (not is_inside and gap.length > MOST_BEYOND):
        return False
    before = _end_slope(path[: gap.begin][::-1]) if gap.begin > 0 else None
    after = _end_slope(path[gap.end :]) if gap.end < len(path) else None
    if is_inside:
        # Hermite's cubic; slopes are per sample, and away from the gap.
        span = gap.length + 1
        t = (np.arange(1, span) / span)[:, None]
        p, q, u, v = path[gap.begin - 1], path[gap.end], -before * span, after * span
        values = p + (3 * t**2 - 2 * t**3) * (q - p) + (t**3 - 2 * t**2 + t) * u + (t**3 - t**2) * v
    elif before is not None:
        values = path[gap.begin - 1] - before * np.arange(1, gap.length + 1)[:, None]
    else:
        values = path[gap.end] - after * np.arange(gap.length, 0, -1)[:, None]
    filled[gap.begin : gap.end, gap.marker] = values
    return True


def _end_slope(path):
    """(3,) slope per sample at the first of (f, 3), of a parabola through it, fitted to the good ones after it."""
    good = path[:SLOPE_SAMPLES][: np.argmax(np.append(np.isnan(path[:SLOPE_SAMPLES, 0]), True))]
    if len(good) < 2:
        return np.zeros(3)
    steps = np.arange(1.0, len(good))
    powers = steps[:, None] ** np.arange(1, min(len(good), 3))
    # A single sample of noise must not throw a long fill far off: slopes of few samples are damped.
    damping = 1.0 if len(good) > 2 else 0.5
    return damping * np.linalg.lstsq(powers, good[1:] - good[0], rcond=None)[0][0]


def _fill_rigidly(filled, how, gaps, variation):
    """Fills what is left of `gaps`, where neighbours are best first: what was filled helps where they are worse."""
    for bound in VARIATIONS:
        near_enough = np.where(variation < bound, variation, np.inf)
        source, usable = filled.copy(), how != MISSING  # a round does not depend on the order of the gaps
        for gap in (gap for gap in gaps if not usable[gap.begin, gap.marker]):
            values = _carried(source, usable, gap, near_enough[gap.marker])
            if values is not None:
                filled[gap.begin : gap.end, gap.marker] = values
                how[gap.begin : gap.end, gap.marker] = RIGID


def _carried(positions, usable, gap, variation):
    """(length, 3): the marker moved with its neighbours from both ends of the gap; None without three that are seen."""
    ends = [frame for frame in (gap.begin - 1, gap.end) if 0 <= frame < len(positions) and usable[frame, gap.marker]]
    if not ends:
        return None
    window = slice(min(gap.begin, *ends, len(positions)), max(gap.end, *(end + 1 for end in ends)))
    seen = usable[window].all(axis=0)
    candidates = np.flatnonzero(seen & np.isfinite(variation))
    neighbours = candidates[np.argsort(variation[candidates], kind="stable")[:MOST_NEIGHBOURS]]
    if len(neighbours) < 3:
        return None
    moving, everything = positions[gap.begin : gap.end], np.flatnonzero(seen)
    at_ends = positions[ends][:, None]  # (ends, 1, m, 3)
    turns = fit_rotations(at_ends[:, :, everything], moving[:, everything])
    moving, around = moving[:, neighbours], at_ends[:, :, neighbours]
    for power in POWERS:
        weights = (variation[neighbours] + NOISE) ** -float(power)
        turns = fit_rotations(around, moving, weights, turns, PRIOR)
    shares = weights / weights.sum()
    offsets = at_ends[:, :, gap.marker] - shares @ around
    paths = shares @ moving + np.einsum("elij,eoj->eli", turns, offsets)
    if len(paths) == 1:
        return paths[0]
    share = np.arange(1, gap.length + 1)[:, None] / (gap.length + 1)
    return (1.0 - share) * paths[0] + share * paths[1]
