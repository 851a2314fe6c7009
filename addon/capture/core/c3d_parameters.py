# SPDX-License-Identifier: GPL-3.0-or-later
"""The parameter section of a C3D file, and the number formats of the three kinds of processors.

Format: "The C3D File Format User Guide", Motion Lab Systems, 2021.
"""

import math
from dataclasses import dataclass

import numpy as np

BLOCK = 512


@dataclass(frozen=True)
class NumberFormat:
    """How a processor writes numbers. VAX floats are in two swapped little-endian words, with another bias."""

    order: str
    is_vax: bool = False

    def numbers(self, data: bytes, kind: str, start: int, count: int) -> np.ndarray:
        """`kind`: of numpy, i1 to u2 and f4."""
        if kind != "f4" or not self.is_vax:
            return np.frombuffer(data, self.order + kind, count, start)
        words = np.frombuffer(data, "<u2", 2 * count, start).reshape(count, 2)
        with np.errstate(all="ignore"):
            return np.ascontiguousarray(words[:, ::-1]).view("<f4")[:, 0] * np.float32(0.25)


#: By the fourth byte of the parameter section: PC, DEC and SGI.
NUMBER_FORMATS = {84: NumberFormat("<"), 85: NumberFormat("<", is_vax=True), 86: NumberFormat(">")}


class Parameters:
    """Values by group and name, decoded when they are asked for."""

    def __init__(self, data: bytes, start: int, end: int, numbers: NumberFormat):
        """Reads what lies in data[start:end]; a damaged entry ends the section, what came before it stays. Of one that
        is there twice the first counts."""
        self._data = data = data[: min(end, len(data))]
        self._numbers = numbers
        self._entries = {}  # (group number, name) -> (type, dimensions, start of the values)
        self._group_numbers = {}
        at, step = start, 1
        while step and at + 4 <= len(data):
            length, group = self._signed(at), self._signed(at + 1)
            link = at + 2 + abs(length)  # a negative length locks the entry
            if length == 0 or group == 0 or link + 2 > len(data):
                break
            name = data[at + 2 : link].decode("latin-1").strip().upper()
            if group < 0:
                self._group_numbers.setdefault(name, -group)
            elif link + 4 <= len(data):
                dimensions = data[link + 4 : link + 4 + data[link + 3]]
                entry = self._signed(link + 2), dimensions, link + 4 + len(dimensions)
                self._entries.setdefault((group, name), entry)
            step = int(numbers.numbers(data, "u2", link, 1)[0])
            at = link + step

    def _signed(self, at):
        return int.from_bytes(self._data[at : at + 1], "little", signed=True)

    def _find(self, group, name, *kinds):
        """(type, dimensions, start, bytes that are left), or None."""
        kind, dimensions, start = self._entries.get((self._group_numbers.get(group), name), (None, (), 0))
        return (kind, dimensions, start, len(self._data) - start) if kind in kinds else None

    def numbers(self, group: str, name: str, signed: bool = False) -> list[float]:
        """The values, empty where there are none; whole numbers count from 0 unless `signed`."""
        found = self._find(group, name, 1, 2, 4)
        if found is None:
            return []
        size, dimensions, start, left = found
        kind = "f4" if size == 4 else f"{'i' if signed else 'u'}{size}"
        count = max(0, min(math.prod(dimensions), left // size))
        return self._numbers.numbers(self._data, kind, start, count).tolist()

    def number(self, group: str, name: str, signed: bool = False) -> float | None:
        values = self.numbers(group, name, signed)
        return values[0] if values else None

    def strings(self, group: str, name: str) -> list[str]:
        """Without the blanks around them; empty where there are none."""
        _, dimensions, start, left = self._find(group, name, -1) or (-1, (0,), 0, 0)
        width = dimensions[0] if dimensions else 1
        if width == 0:
            return []
        count = max(0, min(math.prod(dimensions[1:]), left // width))
        return [_text(self._data[at : at + width]) for at in range(start, start + count * width, width)]

    def all_strings(self, group: str, name: str) -> list[str]:
        """Those of `name` and of its continuations, name2 and so on, as far as there are some."""
        found, number = self.strings(group, name), 2
        while more := self.strings(group, f"{name}{number}"):
            found += more
            number += 1
        return found


def _text(raw):
    raw = raw.split(b"\0", 1)[0]
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    return "".join(letter if letter.isprintable() else " " for letter in text).strip()
