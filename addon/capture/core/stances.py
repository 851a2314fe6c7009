# SPDX-License-Identifier: GPL-3.0-or-later
"""When feet stand: low and slow, with hysteresis."""

import numpy as np

from ...scene.core.sample_times import runs
from .filtering import low_pass

#: Body heights a second, and body heights above the ground: below the first of each a stance begins, above the second
#: it is over. Feet also roll over heel or toes: then they stand on some of their markers.
SLOW, LOW = (0.06, 0.14), (0.03, 0.05)
SHORTEST = 0.06  # seconds
SMOOTHING_HZ = 12.0  # speeds of noise are no speeds


def find_stances(positions, rate_hz, height, slow=SLOW):
    """(f, k) bool: where each marker of a foot stands still on the ground.

    A stance begins where the marker is both low and slow and lasts, forward and backward, while it is not much higher
    or faster. "Low" is above the level that it has for a fiftieth of the time, or above the lowest marker in that
    frame: so floors need not be known, and feet stand on stairs, where each is the lower one for part of its stance.

    positions  (f, k, 3) metres, Z up, of both feet, NaN stands nowhere; smoothed here, as noise has speed. rate_hz
    frames a second; height  of the body, metres; slow  two speeds as SLOW.
    """
    smooth = low_pass(positions, rate_hz, SMOOTHING_HZ) if rate_hz > 3.0 * SMOOTHING_HZ else positions
    speed = np.linalg.norm(np.gradient(smooth, axis=0), axis=2) * rate_hz if len(smooth) > 1 else 0.0 * smooth[..., 0]
    lowest = np.fmin.reduce(smooth[..., 2], axis=1)
    result = np.zeros(positions.shape[:2], bool)
    for marker in range(positions.shape[1]):
        known = ~np.isnan(speed[:, marker])
        if not known.any():
            continue
        heights = smooth[:, marker, 2]
        ground = np.fmax(np.quantile(heights[known], 0.02), lowest)
        surely = known & (speed[:, marker] < slow[0] * height) & (heights - ground < LOW[0] * height)
        for begin, end in _stretches(speed[:, marker] < slow[1] * height, surely):
            level = np.median(heights[begin:end][surely[begin:end]])
            maybe = np.zeros(len(known), bool)
            maybe[begin:end] = heights[begin:end] - level < (LOW[1] - LOW[0]) * height
            for first, last in _stretches(maybe, surely):
                result[first:last, marker] = last - first >= SHORTEST * rate_hz
    return result


def _stretches(flags, surely):
    """Begin and end of the runs of flags (f,) in which something of surely (f,) is."""
    return [(begin, end) for begin, end in runs(flags) if surely[begin:end].any()]
