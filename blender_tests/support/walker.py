# SPDX-License-Identifier: GPL-3.0-or-later
"""A few markers of the walking figure: what tests write into motion capture files."""

import numpy as np

from . import walking_figure

_OF_FIGURE = {
    "HEAD": "HeadTop", "CLAV": "Chest", "LASI": "WaistLFront", "RASI": "WaistRFront", "LKNE": "LKneeOut",
    "RKNE": "RKneeOut", "LHEE": "LHeel", "RHEE": "RHeel",
}  # fmt: skip
LABELS = tuple(_OF_FIGURE)


def positions(frames=20):
    """(frames, 8, 3) metres, Z up, no two frames alike."""
    columns = [walking_figure.LABELS.index(label) for label in _OF_FIGURE.values()]
    return walking_figure.take(frames).clean[:, columns] + [0.03, 0.02, 0.0]


def with_gaps(array, *gaps):
    """A copy, NaN at (marker, first frame, end frame)."""
    result = array.copy()
    for marker, begin, end in gaps:
        result[begin:end, marker] = np.nan
    return result
