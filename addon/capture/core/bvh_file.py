# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads BVH files: each joint and end site becomes a marker, where forward kinematics puts it."""

import re

import numpy as np

from ...errors import MotionFileError
from . import bvh_hierarchy, units
from .bvh_hierarchy import Joint
from .recording import Recording, Take, usable_rate
from .text_lines import Lines, number_in


def read(data: bytes, file: str, up_axis: str | None = None, unit: float | None = None) -> Take:
    """The joints of a BVH file of that content as markers; `file` is its name. Raises MotionFileError."""
    lines = Lines(data, file)
    joints, channels = bvh_hierarchy.read(lines)
    frames, rate = _motion_header(lines)
    notes = []
    motion = lines.table([(number, " ".join(row.split())) for number, row in lines.filled()], channels, frames, notes)
    if len(motion) * len(joints) > max(len(data), 1024):
        raise MotionFileError(
            f"{file}: {len(joints)} joints are more than {channels} channels in {len(motion)} frames can move. The "
            "file is damaged: export it again as BVH"
        )
    with np.errstate(all="ignore"):  # damaged numbers overflow: they are looked at afterwards
        positions = joint_positions(joints, motion)
        rest = joint_positions(joints, np.zeros((1, channels)))
    return Recording(
        file=file,
        rate_hz=rate,
        usual_rate=30.0,
        labels=[joint.name for joint in joints],
        positions=positions,
        usual_up=("Y", "as most BVH files have it"),
        notes=notes,
        is_skeleton=True,
        extent=units.median_extent(rest),
    ).take(up_axis, unit)


def joint_positions(joints: list[Joint], motion: np.ndarray) -> np.ndarray:
    """(f, j, 3) positions for motion (f, channels) in degrees and units of the file; NaN from where a channel is.

    Rotations are applied in the order of their channels: Z X Y is the matrix Rz Rx Ry.
    """
    positions = np.empty((len(motion), len(joints), 3))
    rotations = []
    for index, joint in enumerate(joints):
        local, rotation = _translation(joint, motion), _rotation(joint, motion)
        if joint.parent < 0:
            positions[:, index] = local
        else:
            around = rotations[joint.parent]
            positions[:, index] = positions[:, joint.parent] + np.einsum("fij,fj->fi", around, local)
            rotation = around @ rotation if not joint.is_end else None
        rotations.append(rotation)
    return positions


def _translation(joint, motion):
    """(f, 3) or (1, 3): from the parent, in its axes.

    Most programs write position channels that replace OFFSET; some write what is added to it. What keeps the bone
    nearer to the length of OFFSET counts, and of roots (that have no bone) only zeros are added.
    """
    added = np.array(joint.offset)[None]
    columns = [(joint.first_channel + k, axis) for k, (is_position, axis) in enumerate(joint.channels) if is_position]
    if not columns:
        return added
    added = np.repeat(added, len(motion), axis=0)
    replaced = added.copy()
    for column, axis in columns:
        replaced[:, axis] = motion[:, column]
        added[:, axis] += motion[:, column]
    if joint.parent < 0:
        return replaced if any(motion[:, column].any() for column, _ in columns) else added
    stretched, kept = (
        np.median(np.abs(np.linalg.norm(way, axis=1) - np.linalg.norm(joint.offset))) for way in (replaced, added)
    )
    return added if kept < stretched else replaced


def _rotation(joint, motion):
    """(f, 3, 3) rotation of a joint against its parent; (1, 3, 3) where it has no rotation channels."""
    result = np.eye(3)[None]
    for k, (is_position, axis) in enumerate(joint.channels):
        if not is_position:
            angles = np.radians(motion[:, joint.first_channel + k])
            first, second = (axis + 1) % 3, (axis + 2) % 3
            turn = np.repeat(np.eye(3)[None], len(angles), axis=0)
            turn[:, first, first] = turn[:, second, second] = np.cos(angles)
            turn[:, second, first] = np.sin(angles)
            turn[:, first, second] = -turn[:, second, first]
            result = result @ turn
    return result


def _motion_header(lines):
    """(frames that are told, frames a second or None)."""
    found = re.fullmatch(r"\s*Frames\s*:?\s*(\d{1,9})\s*", lines.next_filled() or "", re.IGNORECASE | re.ASCII)
    if not found:
        lines.fail("'Frames: N' is missing after MOTION")
    timed = re.fullmatch(r"\s*Frame\s*Time\s*:?\s*(\S+)\s*", lines.next_filled() or "", re.IGNORECASE)
    if not timed:
        lines.fail("'Frame Time: SECONDS' is missing after 'Frames'")
    return int(found.group(1)), _rate(timed.group(1))


def _rate(text):
    """Frames a second from a frame time that was rounded to so many digits; None if it is no time."""
    seconds = number_in(text)
    rate = usable_rate(1.0 / seconds) if seconds else None
    if rate is None:
        return None
    digits = re.fullmatch(r"\d*\.(\d+)", text)
    rounding = min(0.51 * 10.0 ** -len(digits.group(1)), 2e-3 * seconds) if digits else 0.0
    whole = round(rate)
    for meant in (whole, whole / 1.001):  # 29.97 and the like are film's and television's
        if meant and abs(1.0 / meant - seconds) <= rounding:
            return float(meant)
    return rate
