# SPDX-License-Identifier: GPL-3.0-or-later
"""Lists of frames as people and render farms write them: `7`, `1-200`, `41,42`, `1-3,10,11`, `1..10`, `-5-10`."""

import re

from ...errors import SceneError

_PART = re.compile(r"\s*(-?\d+)\s*(?:(?:-|\.\.)\s*(-?\d+)\s*)?")

#: More frames than this are a slip of the pen.
MOST_FRAMES = 1_000_000
_MOST_DIGITS = 12


def parse(text):
    """Frames, ascending, each once. @throws SceneError, also for more than MOST_FRAMES."""
    frames = set()
    for part in text.split(","):
        match = _PART.fullmatch(part)
        if match is None:
            raise SceneError(f"'{part.strip()}' in '{text}' is no frame and no range. Write 1-200, or 1-3,10,11")
        if max(map(len, filter(None, match.groups()))) > _MOST_DIGITS:
            raise SceneError(f"'{text[:60]}' has a number that is no frame's. Write 1-200, or 1-3,10,11")
        first, last = int(match[1]), int(match[2] if match[2] is not None else match[1])
        if last < first:
            raise SceneError(f"The range '{part.strip()}' ends before it begins. Write {last}-{first}")
        if len(frames) + last - first >= MOST_FRAMES:
            raise SceneError(
                f"The range '{part.strip()}' has {last - first + 1:,} frames, and at most {MOST_FRAMES:,} are taken. "
                "Write a shorter one"
            )
        frames.update(range(first, last + 1))
    return sorted(frames)


def runs(frames):
    """[(first, last)] of ascending frames."""
    found = []
    for frame in frames:
        if found and frame == found[-1][1] + 1:
            found[-1] = (found[-1][0], frame)
        else:
            found.append((frame, frame))
    return found


def spelled(frames):
    """The shortest way to write ascending frames: `1-3,10-11`; parse() reads it."""
    return ",".join(str(first) if first == last else f"{first}-{last}" for first, last in runs(frames))
