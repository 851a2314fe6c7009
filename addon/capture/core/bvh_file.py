# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads BVH files: each joint and end site becomes a marker, where forward kinematics puts it."""

import math
import re
from array import array
from dataclasses import dataclass, field

import numpy as np

from ...errors import MotionFileError
from ...scene.core.motion import about
from . import units
from .recording import Recording, Take, usable_rate
from .text_lines import Lines, number_in, quoted

#: Channels in lower case -> (True for a position, axis).
CHANNELS = {
    f"{axis}{kind}": (kind == "position", number)
    for number, axis in enumerate("xyz")
    for kind in ("position", "rotation")
}


@dataclass
class Joint:
    """A joint, or the end site of its parent (without channels)."""

    name: str
    parent: int
    offset: tuple[float, float, float] | None = None
    channels: list[tuple[bool, int]] = field(default_factory=list)
    first_channel: int = 0  # column of its first channel in a row of the motion
    is_end: bool = False
    line: int = 0


def read_hierarchy(lines: Lines) -> tuple[list[Joint], int]:
    """(joints, number of channels) from the lines up to MOTION. Raises MotionFileError with the number of the line."""
    statements = _statements(lines)
    first = next(statements, "")
    if first.partition(" ")[0].upper() != "HIERARCHY":
        lines.fail(
            f"this is no BVH file: it begins with {quoted(first)} and should begin with 'HIERARCHY'",
            "Choose the file that was exported as BVH",
        )
    joints, parents, count = [], [], 0  # parents: joints whose braces are open
    for statement in statements:
        word, _, rest = statement.partition(" ")
        word, within = word.upper(), joints[parents[-1]] if parents else None
        is_in_joint = within is not None and not within.is_end
        if word == "MOTION" and within is None and count:
            return joints, count
        if (word == "ROOT" and within is None) or (word in ("JOINT", "END") and is_in_joint):
            is_end = word == "END"
            name = within.name and f"{within.name}_end" if is_end else rest
            joints.append(Joint(name, parents[-1] if parents else -1, is_end=is_end, line=lines.number))
            parents.append(len(joints) - 1)
            if next(statements, "") != "{":
                lines.fail(f"a '{{' is missing after {quoted(name)}")
        elif word == "OFFSET" and within is not None:
            within.offset = _offset(lines, rest.split())
        elif word == "CHANNELS" and is_in_joint and not within.channels:
            within.channels, within.first_channel = _channels(lines, rest.split()), count
            count += len(within.channels)
        elif word == "}" and within is not None:
            if within.offset is None:
                lines.fail(f"joint {quoted(within.name)} (line {within.line}) has no OFFSET")
            parents.pop()
        else:
            where = f"in joint {quoted(within.name)} (line {within.line})" if within else "outside of joints that move"
            lines.fail(f"{quoted(statement)} has no place {where}")
    return lines.fail("the file ends before MOTION")


def _statements(lines):
    """Braces may stand on a line with others."""
    while (line := lines.next_filled()) is not None:
        for piece in line.replace("{", "\n{\n").replace("}", "\n}\n").split("\n"):
            if words := piece.split():
                yield " ".join(words)


def _offset(lines, words):
    values = [number_in(word) for word in words]
    if len(values) != 3 or not all(value is not None and math.isfinite(value) for value in values):
        lines.fail(f"OFFSET needs three numbers, not {quoted(' '.join(words))}")
    return tuple(values)


def _channels(lines, words):
    known = [CHANNELS.get(word.lower()) for word in words[1:]]
    if not words or number_in(words[0]) != len(known):
        lines.fail(f"CHANNELS {quoted(' '.join(words))}: the count is not that of the names")
    if None in known or len(set(known)) < len(known):
        lines.fail(f"CHANNELS {quoted(' '.join(words))}: Xposition ... Zrotation are known, each once")
    return known


def read(data: bytes, file: str, up_axis: str | None = None, unit: float | None = None) -> Take:
    """The joints of a BVH file of that content as markers; `file` is its name. Raises MotionFileError."""
    lines = Lines(data, file)
    joints, channels = read_hierarchy(lines)
    found = re.fullmatch(r"\s*Frames\s*:?\s*(\d{1,9})\s*", lines.next_filled() or "", re.IGNORECASE | re.ASCII)
    if not found:
        lines.fail("'Frames: N' is missing after MOTION")
    timed = re.fullmatch(r"\s*Frame\s*Time\s*:?\s*(\S+)\s*", lines.next_filled() or "", re.IGNORECASE)
    if not timed:
        lines.fail("'Frame Time: SECONDS' is missing after 'Frames'")
    frames, rate = int(found.group(1)), _rate(timed.group(1))
    notes = []
    motion = _motion(lines, channels, frames, notes)
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


def _motion(lines, channels, told, notes):
    """(f, channels) of the lines that are left, a frame each; told: how many there should be."""
    rows = lines.filled()
    if rows and len(rows) <= told and len(rows[-1][1].split()) < channels and lines.is_cut_off(rows[-1][0]):
        rows.pop()
    if not rows:
        lines.fail("there is no whole frame after the header")
    values = array("d")
    for number, line in rows:
        row = line.split()
        if len(row) != channels:
            lines.fail(f"it has {len(row)} numbers where there must be {channels}", number=number)
        try:
            values.extend(map(float, row))
        except ValueError:
            wrong = next(cell for cell in row if number_in(cell) is None)
            lines.fail(f"{quoted(wrong)} is no number", number=number)
    if told != len(rows):
        what = "is cut off" if len(rows) < told else "is longer than it says"
        notes.append(f"The file {what}: {len(rows)} frames are there, {told} are told")
    return np.frombuffer(values, np.float64).reshape(len(rows), channels)


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
            result = result @ about(np.eye(3)[axis], np.radians(motion[:, joint.first_channel + k]))
    return result


def _rate(text):
    """Frames a second from a frame time that was rounded to so many digits; None if it is no time."""
    seconds = number_in(text)
    rate = usable_rate(1.0 / seconds) if seconds else None
    if rate is None:
        return None
    digits, whole = len(text.partition(".")[2]), max(1, round(rate))
    for meant in (whole, whole / 1.001):  # 29.97 and the like are film's and television's
        if round(1.0 / meant, digits) == round(seconds, digits) and abs(meant / rate - 1.0) < 2e-3:
            return float(meant)
    return rate
