# SPDX-License-Identifier: GPL-3.0-or-later
"""Text files of motion capture: decoding, and lines with their numbers."""

from __future__ import annotations

import io
from collections.abc import Iterator


def decoded(data: bytes) -> str:
    """The text in `data`, in whatever encoding: never fails."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", errors="replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


class Lines:
    """Lines of a text one after the other, without their ends. `number` is that of the last one, from 1."""

    def __init__(self, data: bytes):
        self.number = 0
        #: Whether the last line has its end: else the file may have been cut off.
        self.ends_whole = data.rstrip(b" \t").endswith((b"\n", b"\r"))
        self._lines = io.StringIO(decoded(data), newline=None)

    def __iter__(self) -> Iterator[str]:
        for line in self._lines:
            self.number += 1
            yield line.rstrip("\n")

    def next(self) -> str | None:
        """The next line, None at the end."""
        line = self._lines.readline()
        if not line:
            return None
        self.number += 1
        return line.rstrip("\n")

    def next_filled(self) -> str | None:
        """The next line that is not blank, None at the end."""
        while (line := self.next()) is not None:
            if line.strip():
                return line
        return None


def number_in(text: str) -> float | None:
    """The number that `text` is, None if it is none."""
    try:
        return float(text)
    except ValueError:
        return None


def quoted(text: str, longest: int = 40) -> str:
    """For messages: short and printable."""
    shown = "".join(letter if letter.isprintable() else " " for letter in text.strip()[: longest + 1])
    return f"'{shown[:longest]}...'" if len(shown) > longest else f"'{shown}'"
