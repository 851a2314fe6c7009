# SPDX-License-Identifier: GPL-3.0-or-later
"""The hierarchy of a BVH file."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from ...errors import MotionFileError
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

    def __init__(self, lines: Lines, file: str):
        self._lines = lines
        self._file = file
        self.joints: list[Joint] = []
        self.channel_count = 0
        self._open: list[int] = []  # joints whose braces are open
        self._waiting: int | None = None  # the joint whose brace is to come

    def read(self) -> list[Joint]:
        line = self._lines.next_filled()
        if line is None or line.split()[0].upper() != "HIERARCHY":
            self._fail(
                f"this is no BVH file: it begins with {quoted(line or '')} and should begin with 'HIERARCHY'",
                "Choose the file that was exported as BVH",
            )
        while True:
            line = self._lines.next_filled()
            if line is None:
                self._fail("the file ends before MOTION")
            for part in _parts(line):
                if part.upper() == "MOTION":
                    return self._finished()
                self._part(part)

    def _part(self, part):
        word, _, rest = part.partition(" ")
        word, rest = word.upper(), rest.strip()
        if part == "{":
            self._enter()
        elif part == "}":
            self._leave()
        elif word == "ROOT":
            self._begin(rest, is_root=True)
        elif word == "JOINT":
            self._begin(rest)
        elif word == "END":
            self._begin_end()
        elif word == "OFFSET":
            self._offset(rest.split())
        elif word == "CHANNELS":
            self._channels(rest.split())
        else:
            self._fail(f"{quoted(part)} is not understood")

    def _begin(self, name, is_root=False):
        self._expect_no_brace()
        if is_root == bool(self._open):
            self._fail(f"{quoted(name)} is a {'ROOT inside' if is_root else 'JOINT outside'} another joint")
        if self._open and self.joints[self._open[-1]].is_end:
            self._fail(f"an end site holds the joint {quoted(name)}")
        self._append(Joint(name, self._open[-1] if self._open else -1, line=self._lines.number))

    def _begin_end(self):
        self._expect_no_brace()
        if not self._open or self.joints[self._open[-1]].is_end:
            self._fail("an end site is outside a joint")
        parent = self._open[-1]
        name = self.joints[parent].name
        self._append(Joint(f"{name}_end" if name else "", parent, is_end=True, line=self._lines.number))

    def _append(self, joint):
        self.joints.append(joint)
        self._waiting = len(self.joints) - 1

    def _enter(self):
        if self._waiting is None:
            self._fail("a '{' without a joint before it")
        self._open.append(self._waiting)
        self._waiting = None

    def _leave(self):
        self._expect_no_brace()
        if not self._open:
            self._fail("a '}' too many")
        joint = self.joints[self._open.pop()]
        if joint.offset is None:
            self._fail(f"joint {quoted(joint.name)} (line {joint.line}) has no OFFSET")

    def _offset(self, words):
        joint = self._current("OFFSET")
        values = [number_in(word) for word in words]
        if len(values) != 3 or not all(value is not None and math.isfinite(value) for value in values):
            self._fail(f"OFFSET needs three numbers, not {quoted(' '.join(words))}")
        joint.offset = tuple(values)

    def _channels(self, words):
        joint = self._current("CHANNELS")
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
        joint.first_channel = self.channel_count
        self.channel_count += len(known)

    def _current(self, what):
        self._expect_no_brace()
        if not self._open:
            self._fail(f"{what} outside a joint")
        return self.joints[self._open[-1]]

    def _expect_no_brace(self):
        if self._waiting is not None:
            self._fail(f"a '{{' is missing after {quoted(self.joints[self._waiting].name)}")

    def _finished(self):
        self._expect_no_brace()
        if self._open:
            joint = self.joints[self._open[-1]]
            self._fail(f"MOTION begins inside joint {quoted(joint.name)} (line {joint.line}): a '}}' is missing")
        if not self.joints or self.channel_count == 0:
            self._fail("the hierarchy has no joint that moves")
        return self.joints

    def _fail(self, reason, remedy="Export it again as BVH, or mend the line in a text editor"):
        raise MotionFileError(f"{self._file}, line {self._lines.number}: {reason}. {remedy}")


def _parts(line):
    """A line in its statements: braces may stand on a line with others."""
    for piece in line.replace("{", "\n{\n").replace("}", "\n}\n").split("\n"):
        part = " ".join(piece.split())
        if part:
            yield part
