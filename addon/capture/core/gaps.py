# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples that no camera saw: found, and filled where what is known around them tells enough; and
noise, taken off paths without delaying them."""

import numpy as np

from ...errors import InvalidMotionError
from ...scene.core.motion import fit_rotations
from ...scene.core.sample_times import runs

#: Good samples beside a gap that its slope is read from.
SLOPE_SAMPLES = 5
#: Neighbors that carry a marker through a gap.
MOST_NEIGHBOURS = 6
#: Meters that the distances of a gap's neighbours may vary by: the best first, and none worse than the last.
VARIATIONS = (0.01, 0.03, 0.1)
#: Meters that no difference in variation is made of.
NOISE = 0.001
#: Neighbors are weighted by these powers of how little their distances vary, one after the other: each settles the
#: turn that the next leaves open, where few count and lie on a line. A segment with three markers needs no others;
#: where it has two those of the next one must count for little, but not for nothing.
POWERS, PRIOR = (1, 3), 0.05
#: A neighbor's distance may vary by this share of it (standard deviation), or it is no neighbor.
LARGEST_VARIATION = 0.2
#: Frames in which two markers must be seen together before anything is said of their distance.
LEAST_TOGETHER = 10


def fill_gaps(positions, longest_spline=10, longest_rigid=200):
    """(f, m, 3) float64: positions (f, m, 3), filled where they are NaN. Measured samples keep their bits.

    longest_spline  in samples: gaps up to that long are cubics, with place and slope of the good samples on both sides.
    longest_rigid  in samples: longer gaps, up to that, and those at the take's ends move rigidly with the neighbors
        whose distances vary least (Aristidou and Lasenby 2013 predict markers so); both ends are met.
    Still longer gaps, and those with less than three usable neighbors, stay NaN.
    """
    filled = positions.copy()
    missing = np.isnan(positions[..., 0])
    gaps = [(marker, *run) for marker in range(missing.shape[1]) for run in runs(missing[:, marker]).tolist()]
    for marker, begin, end in gaps:
        if end - begin <= longest_spline and begin > 0 and end < len(positions):
            before, after = -_slope(positions[:begin, marker][::-1]), _slope(positions[end:, marker])
            (first, last), span = positions[[begin - 1, end], marker], end - begin + 1
            t = (np.arange(1, span) / span)[:, None]
            bends = (t**3 - 2 * t**2 + t) * span * before + (t**3 - t**2) * span * after
            filled[begin:end, marker] = first + (3 * t**2 - 2 * t**3) * (last - first) + bends
    gaps = [(marker, begin, end) for marker, begin, end in gaps if end - begin <= longest_rigid]
    variation = distance_variation(positions)
    for bound in VARIATIONS:  # the best neighbours first: what was filled helps where they are worse
        near_enough = np.where(variation < bound, variation, np.inf)
        source, usable = filled.copy(), ~np.isnan(filled[..., 0])  # a round does not depend on the order of the gaps
        for marker, begin, end in (gap for gap in gaps if not usable[gap[1], gap[0]]):
            filled[begin:end, marker] = _carried(source, usable, marker, begin, end, near_enough[marker])
    return filled


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


def _slope(path):
    """(3,) a sample at the first of (f, 3), of a parabola through it, fitted to the good ones after it."""
    good = path[:SLOPE_SAMPLES][: np.argmax(np.append(np.isnan(path[:SLOPE_SAMPLES, 0]), True))]
    powers = np.arange(1.0, len(good))[:, None] ** np.arange(1, min(len(good), 3))
    return np.linalg.lstsq(powers, good[1:] - good[0], rcond=None)[0][0] if len(good) > 1 else np.zeros(3)


def _carried(positions, usable, marker, begin, end, variation):
    """(end - begin, 3): the marker moved with its neighbours from both ends of the gap; NaN without three."""
    ends = [frame for frame in (begin - 1, end) if 0 <= frame < len(positions) and usable[frame, marker]]
    if not ends:
        return np.nan
    window = slice(min(begin, *ends, len(positions)), max(end, *(frame + 1 for frame in ends)))
    seen = usable[window].all(axis=0)
    candidates = np.flatnonzero(seen & np.isfinite(variation))
    neighbours = candidates[np.argsort(variation[candidates], kind="stable")[:MOST_NEIGHBOURS]]
    if len(neighbours) < 3:
        return np.nan
    at_ends = positions[ends][:, None]  # (ends, 1, m, 3)
    moving, around, turns = positions[begin:end, neighbours], at_ends[:, :, neighbours], None
    for power in POWERS:
        weights = (variation[neighbours] + NOISE) ** -float(power)
        turns = fit_rotations(around, moving, weights, turns, PRIOR)
    shares = weights / weights.sum()
    offsets = at_ends[:, :, marker] - shares @ around
    paths = shares @ moving + np.einsum("elij,eoj->eli", turns, offsets)
    if len(paths) == 1:
        return paths[0]
    share = np.arange(1, end - begin + 1)[:, None] / (end - begin + 1)
    return (1.0 - share) * paths[0] + share * paths[1]


def low_pass(positions, rate_hz, cutoff_hz):
    """(f, m, 3) float64: the paths without what is faster than `cutoff_hz`, where half of the power is left.

    Butterworth's filter of second order, forward and backward (Winter, Biomechanics and Motor Control of Human
    Movement, 2009), by its gain on the spectrum of each run between gaps. NaN stays NaN.

    positions  (f, m, 3); rate_hz  frames a second. Raises InvalidMotionError unless cutoff_hz is below half of that.
    """
    if not cutoff_hz < 0.5 * rate_hz:
        raise InvalidMotionError(
            f"The cut-off of {cutoff_hz:g} Hz must be below half the frame rate, {0.5 * rate_hz:g} Hz: there is no "
            "faster motion in the take"
        )
    result = positions.copy()
    good = ~np.isnan(result[..., 0])
    for marker in range(result.shape[1]):
        for begin, end in runs(good[:, marker]):
            path = result[begin:end, marker]
            # Beyond its ends it goes on as its point reflection: about the line between them that is periodic.
            line = path[0] + np.linspace(0.0, 1.0, len(path))[:, None] * (path[-1] - path[0])
            away = path - line
            periodic = np.concatenate([away, -away[-2:0:-1]])
            # Each of the two passes leaves 2^(-1/4) of the amplitude at the cut-off.
            cycles = np.fft.rfftfreq(len(periodic)) / (cutoff_hz / rate_hz)
            spectrum = (1.0 / (1.0 + (np.sqrt(2.0) - 1.0) * cycles**4))[:, None] * np.fft.rfft(periodic, axis=0)
            result[begin:end, marker] = line + np.fft.irfft(spectrum, len(periodic), axis=0)[: len(path)]
    return result
