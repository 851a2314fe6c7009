# SPDX-License-Identifier: GPL-3.0-or-later
"""Which frames of an animated shape to keep, so that blending from one to the next gives the others."""

import numpy as np


def reduced(rows, times, tolerance):
    """Generator of the rows to keep: the first, the last and as few between as it takes. Yields the share done.

    Each span is about as long as it can be, found by halving; every row within was looked at. So between two rows that
    are kept no vertex is farther than `tolerance` from where the blend has it.

    rows: sequence of (n, 3) float32; times: their frames, ascending; tolerance >= 0. Returns ascending row numbers.
    """
    kept = [0]
    last = len(rows) - 1
    while kept[-1] < last:
        begin, good, bad = kept[-1], kept[-1] + 1, last + 1
        while bad - good > 1:
            middle = (good + bad) // 2
            if _blend_is_near(rows, times, begin, middle, tolerance):
                good = middle
            else:
                bad = middle
            yield good / last
        kept.append(good)
    return kept


def _blend_is_near(rows, times, begin, end, tolerance):
    first, last = np.array(rows[begin], np.float64), np.array(rows[end], np.float64)
    middle = (begin + end) // 2  # where it is usually farthest
    for row in sorted(range(begin + 1, end), key=lambda row: abs(row - middle)):
        share = (times[row] - times[begin]) / (times[end] - times[begin])
        if np.linalg.norm(first + share * (last - first) - rows[row], axis=1).max(initial=0.0) > tolerance:
            return False
    return True
