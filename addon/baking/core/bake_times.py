# SPDX-License-Identifier: GPL-3.0-or-later
"""The frames that a bake samples, what is said of those that went wrong, and which to keep to blend the others of."""

import numpy as np

from ... import wording
from ...errors import SceneError

#: Said of a frame that the shape snaps at, from the one before.
SNAPS = "the pose snaps"

#: Frames that are named in a message.
MOST_NAMES = 8


def sample_times(start, end, samples=1):
    """f float64: frames from `start` to `end`, `samples` for each. @throws SceneError."""
    if end < start:
        raise SceneError(f"The range ends before it begins (frames {start} to {end}). Exchange Start and End")
    return start + np.arange((end - start) * samples + 1) / samples


def notes(times, problems):
    """Sentences on frames to look at. problems: f texts, "" where all went well."""
    for problem in sorted(set(problems) - {""}):
        names = [wording.frame(time) for time, each in zip(times, problems, strict=True) if each == problem]
        shown = ", ".join(names[:MOST_NAMES]) + (", ..." if len(names) > MOST_NAMES else "")
        if problem == SNAPS:
            yield f"The pose snaps at {'frame' if len(names) == 1 else 'frames'} {shown}: key one in between"
            continue
        yield f"{wording.counted(len(names), 'frame')} {problem} ({shown})"


def reduced(rows, times, tolerance):
    """Generator of the rows to keep: as few as leave no vertex farther than `tolerance` from where the blend of the two
    beside has it. Yields the share done. Each span is about as long as it can be, found by halving.

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
