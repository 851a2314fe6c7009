# SPDX-License-Identifier: GPL-3.0-or-later
"""Text files of motion capture: decoding, and lines with their numbers."""

import io
from collections.abc import Iterator

from ...errors import MotionFileError

REMEDY = "Export it again, or mend the line in a text editor"

#: Letters of a file that a message shows.
MOST_QUOTED = 40


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

    def __init__(self, data: bytes, file: str):
        self.number, self.size = 0, len(data)
        self._file = file
        self._ends_whole = data.rstrip(b" \t").endswith((b"\n", b"\r"))  # else the file may have been cut off
        self._lines = io.StringIO(decoded(data), newline=None)

    def __iter__(self) -> Iterator[str]:
        for line in self._lines:
            self.number += 1
            yield line.rstrip("\n")

    def next_filled(self) -> str | None:
        """The next line that is not blank, None at the end."""
        return next((line for line in self if line.strip()), None)

    def filled(self) -> list[tuple[int, str]]:
        """(number, text) of all lines that are left and not blank."""
        return [(self.number, line) for line in self if line.strip()]

    def fail(self, reason: str, remedy: str = REMEDY, number: int | None = None):
        """Raises MotionFileError with the file, the last line or that of `number`, the reason and a remedy."""
        raise MotionFileError(f"{self._file}, line {number or self.number}: {reason}. {remedy}")

    def is_cut_off(self, number: int) -> bool:
        """Whether the file may have been cut off in the line `number`, its last one."""
        return number == self.number and not self._ends_whole


def number_in(text: str) -> float | None:
    """The number that `text` is, None if it is none."""
    try:
        return float(text)
    except ValueError:
        return None


def quoted(text: str) -> str:
    """For messages: short and printable."""
    shown = "".join(letter if letter.isprintable() else " " for letter in text.strip()[: MOST_QUOTED + 1])
    return f"'{shown[:MOST_QUOTED]}...'" if len(shown) > MOST_QUOTED else f"'{shown}'"
