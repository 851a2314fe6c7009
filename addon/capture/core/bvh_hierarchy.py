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


class HierarchyReader:
    """Reads lines from HIERARCHY to MOTION. Raises MotionFileError with the number of the line."""

    def __init__(self, lines: Lines):
        self._lines = lines
        self._fail = lines.fail
        self._joints: list[Joint] = []
        self._channel_count = 0
        self._open: list[int] = []  # joints whose braces are open

    def read(self) -> tuple[list[Joint], int]:
        """(joints, number of channels)."""
        statements = self._statements()
        first = next(statements, "")
        if first.partition(" ")[0].upper() != "HIERARCHY":
            self._fail(
                f"this is no BVH file: it begins with {quoted(first)} and should begin with 'HIERARCHY'",
                "Choose the file that was exported as BVH",
            )
        for statement in statements:
            word, _, rest = statement.partition(" ")
            if word.upper() == "MOTION":
                return self._finished()
            if word.upper() in ("ROOT", "JOINT", "END"):
                self._begin(word.upper(), rest)
                if next(statements, "") != "{":
                    self._fail(f"a '{{' is missing after {quoted(self._joints[-1].name)}")
                self._open.append(len(self._joints) - 1)
            elif word == "}":
                self._leave()
            elif word.upper() in ("OFFSET", "CHANNELS"):
                if not self._open:
                    self._fail(f"{word} outside a joint")
                take = self._offset if word.upper() == "OFFSET" else self._channels
                take(self._joints[self._open[-1]], rest.split())
            else:
                self._fail(f"{quoted(statement)} is not understood")
        return self._fail("the file ends before MOTION")

    def _statements(self):
        """Braces may stand on a line with others."""
        while (line := self._lines.next_filled()) is not None:
            for piece in line.replace("{", "\n{\n").replace("}", "\n}\n").split("\n"):
                if words := piece.split():
                    yield " ".join(words)

    def _begin(self, kind, name):
        parent = self._open[-1] if self._open else -1
        if (kind == "ROOT") == bool(self._open):
            self._fail(f"{quoted(name)} is a {kind} {'inside' if self._open else 'outside'} another joint")
        if self._open and self._joints[parent].is_end:
            self._fail(f"an end site holds the joint {quoted(name)}")
        if kind == "END":
            name = self._joints[parent].name and f"{self._joints[parent].name}_end"
        self._joints.append(Joint(name, parent, is_end=kind == "END", line=self._lines.number))

    def _leave(self):
        if not self._open:
            self._fail("a '}' too many")
        joint = self._joints[self._open.pop()]
        if joint.offset is None:
            self._fail(f"joint {quoted(joint.name)} (line {joint.line}) has no OFFSET")

    def _offset(self, joint, words):
        values = [number_in(word) for word in words]
        if len(values) != 3 or not all(value is not None and math.isfinite(value) for value in values):
            self._fail(f"OFFSET needs three numbers, not {quoted(' '.join(words))}")
        joint.offset = tuple(values)

    def _channels(self, joint, words):
        if joint.is_end:
            self._fail("an end site has no CHANNELS")
        if joint.channels:
            self._fail(f"joint {quoted(joint.name)} has CHANNELS twice")
        known = [CHANNELS.get(word.lower()) for word in words[1:]]
        if not words or number_in(words[0]) != len(known):
            self._fail(f"CHANNELS {quoted(' '.join(words))}: the count is not that of the names")
        if None in known or len(set(known)) < len(known):
            self._fail(f"CHANNELS {quoted(' '.join(words))}: Xposition ... Zrotation are known, each once")
        joint.channels = known
        joint.first_channel = self._channel_count
        self._channel_count += len(known)

    def _finished(self):
        if self._open:
            joint = self._joints[self._open[-1]]
            self._fail(f"MOTION begins inside joint {quoted(joint.name)} (line {joint.line}): a '}}' is missing")
        if not self._joints or self._channel_count == 0:
            self._fail("the hierarchy has no joint that moves")
        return self._joints, self._channel_count
