# SPDX-License-Identifier: GPL-3.0-or-later
"""The parameter section of a C3D file, and the number formats of the three kinds of processors.

Format: "The C3D File Format User Guide", Motion Lab Systems, 2021.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

BLOCK = 512

#: The groups that say something of markers; the others are passed over.
GROUPS = ("POINT", "ANALOG", "TRIAL", "MANUFACTURER")


@dataclass(frozen=True)
class NumberFormat:
    """How a processor writes numbers. VAX floats are in two swapped little-endian words, with another bias."""

    name: str
    order: str
    vax: bool = False

    def uint16(self, data, start, count):
        return np.frombuffer(data, f"{self.order}u2", count, start)

    def int16(self, data, start, count):
        return np.frombuffer(data, f"{self.order}i2", count, start)

    def float32(self, data, start, count):
        if not self.vax:
            return np.frombuffer(data, f"{self.order}f4", count, start)
        words = np.frombuffer(data, "<u2", 2 * count, start).reshape(count, 2)
        with np.errstate(all="ignore"):
            return np.ascontiguousarray(words[:, ::-1]).view("<f4")[:, 0] * np.float32(0.25)


#: By the fourth byte of the parameter section.
NUMBER_FORMATS = {
    84: NumberFormat("PC", "<"),
    85: NumberFormat("DEC", "<", vax=True),
    86: NumberFormat("SGI", ">"),
}


class Parameters:
    """Values by group and name, decoded when they are asked for."""

    def __init__(self, data: bytes, start: int, end: int, numbers: NumberFormat):
        """Reads what lies in data[start:end]; a damaged entry ends the section, what came before it stays."""
        self._data = data
        self._end = min(end, len(data))
        self._numbers = numbers
        self._entries = {}  # (group number, name) -> (type, dimensions, start of the values)
        self._group_numbers = {}
        self._scan(start)

    def _scan(self, start):
        data, at = self._data, start
        while at + 4 <= self._end:
            length, group = data[at], int.from_bytes(data[at + 1 : at + 2], "little", signed=True)
            length = 256 - length if length > 127 else length  # a negative length locks the entry
            link = at + 2 + length
            if length == 0 or group == 0 or link + 2 > self._end:
                return
            name = data[at + 2 : link].decode("latin-1").strip().upper()
            if group < 0:
                if name in GROUPS:
                    self._group_numbers.setdefault(name, -group)
            elif link + 4 <= self._end:
                self._remember(group, name, link + 2)
            step = int(self._numbers.uint16(data, link, 1)[0])
            if step == 0:
                return
            at = link + step

    def _remember(self, group, name, at):
        """Of an entry that is there twice the first counts."""
        kind = int.from_bytes(self._data[at : at + 1], "little", signed=True)
        dimensions = self._data[at + 2 : at + 2 + self._data[at + 1]]
        self._entries.setdefault((group, name), (kind, dimensions, at + 2 + len(dimensions)))

    def _find(self, group, name):
        return self._entries.get((self._group_numbers.get(group), name))

    def names(self, group: str) -> list[str]:
        number = self._group_numbers.get(group)
        return [name for owner, name in self._entries if owner == number]

    def numbers(self, group: str, name: str, signed: bool = False) -> list[float]:
        """The values, empty where there are none; whole numbers count from 0 unless `signed`."""
        found = self._find(group, name)
        if found is None or found[0] not in (1, 2, 4):
            return []
        kind, dimensions, start = found
        count = max(0, min(_product(dimensions), (self._end - start) // kind))
        if kind == 4:
            return [float(value) for value in self._numbers.float32(self._data, start, count)]
        if kind == 2:
            values = (self._numbers.int16 if signed else self._numbers.uint16)(self._data, start, count)
        else:
            values = np.frombuffer(self._data, "i1" if signed else "u1", count, start)
        return [int(value) for value in values]

    def number(self, group: str, name: str, signed: bool = False) -> float | None:
        values = self.numbers(group, name, signed)
        return values[0] if values else None

    def strings(self, group: str, name: str) -> list[str]:
        """Without the blanks around them; empty where there are none."""
        found = self._find(group, name)
        if found is None or found[0] != -1:
            return []
        _, dimensions, start = found
        width = dimensions[0] if dimensions else 1
        if width == 0:
            return []
        count = max(0, min(_product(dimensions[1:]), (self._end - start) // width))
        return [_text(self._data[at : at + width]) for at in range(start, start + count * width, width)]

    def string(self, group: str, name: str) -> str:
        return " ".join(self.strings(group, name)).strip()


def _product(dimensions):
    result = 1
    for dimension in dimensions:
        result *= dimension
    return result


def _text(raw):
    raw = raw.split(b"\0", 1)[0]
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    return "".join(letter if letter.isprintable() else " " for letter in text).strip()
