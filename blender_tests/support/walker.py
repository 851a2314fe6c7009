# SPDX-License-Identifier: GPL-3.0-or-later
"""A few markers that walk: what tests write into motion capture files."""

import numpy as np

LABELS = ("HEAD", "CLAV", "LASI", "RASI", "LKNE", "RKNE", "LHEE", "RHEE")
_STANDING = np.array(
    [
        (0.0, 0.05, 1.72),
        (0.02, 0.0, 1.42),
        (0.03, 0.13, 0.98),
        (0.03, -0.13, 0.98),
        (0.01, 0.16, 0.51),
        (0.0, -0.16, 0.51),
        (-0.05, 0.11, 0.04),
        (-0.05, -0.11, 0.04),
    ]
)


def positions(frames=20, rate=100.0):
    """(frames, 8, 3) metres, Z up: walks along X and swings, no two frames alike, feet near the floor."""
    time = np.arange(frames)[:, None] / rate
    side = np.sign(_STANDING[:, 1])
    swing = (1.7 - _STANDING[:, 2]) * np.sin(2.0 * np.pi * time + side) * 0.2
    result = np.repeat(_STANDING[None], frames, axis=0)
    result[..., 0] += 1.2 * time + swing
    result[..., 1] += 0.02 * np.sin(3.0 * time) + 0.3
    result[..., 2] += 0.02 * np.abs(swing)
    return result


def with_gaps(array, *gaps):
    """A copy, NaN at (marker, first frame, end frame)."""
    result = array.copy()
    for marker, begin, end in gaps:
        result[begin:end, marker] = np.nan
    return result
