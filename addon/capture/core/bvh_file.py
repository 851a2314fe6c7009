# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads BVH files: each joint and end site becomes a marker, where forward kinematics puts it."""

from __future__ import annotations

import math
import re
from array import array
from dataclasses import dataclass, field

import numpy as np

from ...errors import MotionFileError
from . import units
from .bvh_hierarchy import HierarchyReader
from .forward_kinematics import joint_positions, rest_positions
from .recording import Recording
from .take import Take
from .text_lines import Lines, number_in, quoted

AGAIN = "Export it again as BVH, or mend the line in a text editor"
RATE_WITHOUT = 30.0


def read(data: bytes, file: str, up_axis: str | None = None, unit: float | None = None) -> Take:
    """The joints of a BVH file of that content as markers; `file` is its name. Raises MotionFileError."""
    lines = Lines(data)
    hierarchy = HierarchyReader(lines, file)
    joints = hierarchy.read()
    notes = []
    frames, rate = _motion_header(lines, file, notes)
    motion = _motion(lines, file, hierarchy.channel_count, frames, notes)
    if len(motion) * len(joints) > max(len(data), 1024):
        raise MotionFileError(
            f"{file}: {len(joints)} joints are more than {hierarchy.channel_count} channels in {len(motion)} frames "
            "can move. The file is damaged: export it again as BVH"
        )
    with np.errstate(all="ignore"):  # damaged numbers overflow: they are looked at afterwards
        positions = joint_positions(joints, motion)
    return _Skeleton(
        file=file,
        rate_hz=rate,
        first_frame=1,
        labels=[joint.name for joint in joints],
        positions=positions,
        usual_up=("Y", "as most BVH files have it"),
        notes=notes,
        parents=tuple(joint.parent for joint in joints),
        zero_is_missing=False,
        drops_never_seen=False,
        rest=rest_positions(joints),
    ).take(up_axis, unit)


@dataclass
class _Skeleton(Recording):
    """A recording whose rest pose tells size and upright axis."""

    #: (j, 3) in the file's unit and axes.
    rest: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))

    def spread(self, positions):
        return units.median_extent(self.rest[None])

    def seen_up(self, positions):
        """The axis from the hips to the head in the rest pose, where that is clear."""
        for wanted in ("head", "neck", "chest", "spine"):
            for index in (index for index, label in enumerate(self.labels) if wanted in label.lower()):
                up = self.rest[index] - self.rest[0]
                axis = int(np.argmax(np.abs(up)))
                if np.abs(up[axis]) > 0.8 * np.linalg.norm(up) > 0.0:
                    why = f"along which {quoted(self.labels[index])} is above the hips"
                    return ("-" if up[axis] < 0.0 else "") + "XYZ"[axis], why
        return super().seen_up(positions)


def _motion_header(lines, file, notes):
    """(frames that are told, frames a second)."""
    frames_line, time_line = lines.next_filled(), lines.next_filled()
    found = re.fullmatch(r"\s*Frames\s*:?\s*(\d{1,9})\s*", frames_line or "", re.IGNORECASE | re.ASCII)
    if not found:
        raise MotionFileError(f"{file}, line {lines.number}: 'Frames: N' is missing after MOTION. {AGAIN}")
    timed = re.fullmatch(r"\s*Frame\s*Time\s*:?\s*(\S+)\s*", time_line or "", re.IGNORECASE)
    if not timed:
        raise MotionFileError(f"{file}, line {lines.number}: 'Frame Time: SECONDS' is missing after 'Frames'. {AGAIN}")
    return int(found.group(1)), _rate(timed.group(1), notes)


def _rate(text, notes):
    """Frames a second from a frame time that was rounded to so many digits."""
    seconds = number_in(text)
    if seconds is None or not (math.isfinite(seconds) and 1e-6 <= seconds <= 1e3):
        notes.append(f"The frame time {quoted(text)} is no time: {RATE_WITHOUT:g} frames a second are assumed")
        return RATE_WITHOUT
    digits = re.fullmatch(r"\d*\.(\d+)", text)
    rounding = min(0.51 * 10.0 ** -len(digits.group(1)), 2e-3 * seconds) if digits else 0.0
    whole = round(1.0 / seconds)
    for meant in (whole, whole / 1.001):  # 29.97 and the like are film's and television's
        if meant and abs(1.0 / meant - seconds) <= rounding:
            return float(meant)
    return 1.0 / seconds


def _motion(lines, file, channels, told, notes):
    """(f, channels) float64. A last row that is cut off is dropped."""
    values = array("d")
    rows = [(lines.number, line) for line in lines if line.strip()]
    count = len(rows)
    if rows and len(rows[-1][1].split()) < channels and count <= told:
        count -= 1
    for number, line in rows[:count]:
        words = line.split()
        if len(words) != channels:
            raise MotionFileError(
                f"{file}, line {number}: it has {len(words)} numbers, and the hierarchy has {channels} channels. "
                f"{AGAIN}"
            )
        try:
            values.extend(map(float, words))
        except ValueError:
            wrong = next(word for word in words if number_in(word) is None)
            raise MotionFileError(f"{file}, line {number}: {quoted(wrong)} is no number. {AGAIN}") from None
    if count == 0:
        raise MotionFileError(f"{file}: it has no whole frame after 'Frame Time'. {AGAIN}")
    if count != told:
        what = "is cut off" if count < told else "is longer than it says"
        notes.append(f"The file {what}: {count} frames are there, {told} are told")
    return np.frombuffer(values, np.float64).reshape(count, channels)
