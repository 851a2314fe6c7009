# SPDX-License-Identifier: GPL-3.0-or-later
"""The hierarchy of a BVH file."""

import math
from dataclasses import dataclass, field

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
    #: Column of its first channel in a row of the motion.
    first_channel: int = 0
    is_end: bool = False
    line: int = 0


def read(lines: Lines) -> tuple[list[Joint], int]:
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
