# SPDX-License-Identifier: GPL-3.0-or-later
"""Text files of motion capture: decoding, lines with their numbers, and rows of numbers."""

import io
import math
from array import array
from collections.abc import Iterator

import numpy as np

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
        self.number = 0
        self._file = file
        self._ends_whole = data.rstrip(b" \t").endswith((b"\n", b"\r"))  # else the file may have been cut off
        self._lines = io.StringIO(decoded(data), newline=None)

    def __iter__(self) -> Iterator[str]:
        for line in self._lines:
            self.number += 1
            yield line.rstrip("\n")

    def next(self) -> str | None:
        """The next line, None at the end."""
        return next(iter(self), None)

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

    def table(self, rows: list[tuple[int, str]], width: int, told: int | None, notes: list[str]) -> np.ndarray:
        """(f, width) float64 of rows (line number, text), a frame each; NaN for what is blank between tabs.

        `told`: how many the header tells, or None. A last row that is cut off is dropped, and another number than told
        is noted. Raises MotionFileError for what is no number, and for rows of another width (but ones with tabs may
        end early).
        """
        is_cut = rows and not self._ends_whole and len(cells(rows[-1][1], width)) < width
        if is_cut and (told is None or len(rows) <= told):
            rows = rows[:-1]
        if not rows:
            self.fail("there is no whole frame after the header")
        values = array("d")
        for number, line in rows:
            found = cells(line, width)
            if len(found) > width or ("\t" not in line and len(found) != width):
                self.fail(f"it has {len(found)} numbers where there must be {width}", number=number)
            try:
                values.extend([float(cell.strip() or "nan") for cell in found])
            except ValueError:
                wrong = next(cell for cell in found if cell.strip() and number_in(cell) is None)
                self.fail(f"{quoted(wrong)} is no number", number=number)
            values.extend([math.nan] * (width - len(found)))
        if told is not None and told != len(rows):
            what = "is cut off" if len(rows) < told else "is longer than it says"
            notes.append(f"The file {what}: {len(rows)} frames are there, {told} are told")
        return np.frombuffer(values, np.float64).reshape(len(rows), width)


def cells(line: str, width: int) -> list[str]:
    """What stands in a row between tabs or, without tabs, between blanks; blank cells beyond `width` are none."""
    found = line.rstrip("\r").split("\t") if "\t" in line else line.split()
    while len(found) > width and not found[-1].strip():
        found.pop()
    return found


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
