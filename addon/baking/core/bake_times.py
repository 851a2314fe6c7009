# SPDX-License-Identifier: GPL-3.0-or-later
"""The frames that a bake samples, what they are called, and what is said of those that went wrong."""

import numpy as np

from ... import wording
from ...errors import SceneError
from ...scene.core.sample_times import named

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
        names = [named(time) for time, each in zip(times, problems, strict=True) if each == problem]
        shown = ", ".join(names[:MOST_NAMES]) + (", ..." if len(names) > MOST_NAMES else "")
        if problem == SNAPS:
            yield f"The pose snaps at {'frame' if len(names) == 1 else 'frames'} {shown}: key one in between"
            continue
        yield f"{wording.counted(len(names), 'frame')} {problem} ({shown})"
