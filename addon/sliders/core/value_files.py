# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads files of shape values by name, a frame a row: CSV, as recorders of faces write it, and JSON."""

import csv
import json
import math
from dataclasses import dataclass

import numpy as np

from ... import wording
from ...capture.core.readers import read_by
from ...capture.core.text_lines import Lines, decoded, number_in, quoted
from ...errors import MotionFileError
from .key_names import folded

SUFFIXES = (".csv", ".json")

#: Columns and entries that are no values, and what JSON files call their parts; all as folded() has them.
NO_VALUES = {"blendshapecount", "time", "timestamp", "timecode", "frame"}
TIMES = ("time", "timestamp", "timecode", "frame")
NAMES, FRAMES, RATES = ("names", "facsnames"), ("frames", "weightmat"), ("fps", "rate", "exportfps")
NESTED = ("values", "blendshapes", "weights")

#: What the frames in a timecode may count, in a second.
RATES_OF_TIMECODES = (24, 25, 30, 48, 50, 60, 100, 120)
DAY_SECONDS = 86400.0

#: What is larger is no value of a shape, and no time.
LARGEST_VALUE, LARGEST_TIME = 1e6, 1e15


@dataclass(frozen=True, eq=False)
class RecordedValues:
    """names: s names as in the file; values: (f, s) float64, NaN where one is missing.

    times: (f,) float64 ascending from 0, in frames of the recording; rate_hz: of them, or None: as the scene's.
    notes: sentences on what was left out.
    """

    names: tuple
    values: np.ndarray
    times: np.ndarray
    rate_hz: float | None
    notes: tuple = ()


def read(path, rate_hz=None):
    """The RecordedValues of a file. rate_hz: frames a second of the recording; None: as the file tells.

    @throws MotionFileError with the file's name, the line and a remedy.
    """
    return read_by({".csv": parse_csv, ".json": parse_json}, path, rate_hz)


def parse_csv(data, file, rate_hz=None):
    """Of bytes: a header with names, and rows; the first column is a time, a timecode or a frame. As read()."""
    lines = Lines(data, file)
    header = lines.next_filled()
    if header is None:
        lines.fail("the file is empty", remedy="Export it again", number=1)
    delimiter = max(",;\t", key=header.count)
    head = [cell.strip() for cell in _cells(lines, lines.number, header, delimiter)]
    columns = [number for number in range(1, len(head)) if head[number] and folded(head[number]) not in NO_VALUES]
    names = [head[number] for number in columns]
    if not names or all(number_in(name) is not None for name in names):
        lines.fail("it has no names of shapes. The first line must be a header: time, name, name, ...")
    twice = next((name for number, name in enumerate(names) if name in names[:number]), None)
    if twice is not None:
        lines.fail(f"two columns are called {quoted(twice)}")
    rows, numbers, stamps = [], [], []
    for number, line in lines.filled():
        cells = _cells(lines, number, line, delimiter)
        if len(cells) < len(head) and lines.is_cut_off(number):
            break
        if len(cells) != len(head):
            lines.fail(f"it has {len(cells)} columns where the header has {len(head)}", number=number)
        if delimiter == ";":  # where commas stand in numbers
            cells = [cell.replace(",", ".") for cell in cells]
        rows.append([_number(lines, number, cells[column], head[column]) for column in columns])
        stamps.append(cells[0].strip())
        numbers.append(number)
    if not rows:
        lines.fail("there is no whole row after the header")

    def fail(row, reason):
        lines.fail(reason, number=numbers[row])

    return _made(names, rows, stamps, head[0], rate_hz, fail)


def parse_json(data, file, rate_hz=None):
    """Of bytes: [{name: value, ...}, ...] or {"names": [...], "frames": [[...], ...]}. As read()."""

    def fail(row, reason):
        raise MotionFileError(f"{file}, frame {row + 1} of the file: {reason}. Export it again")

    try:
        whole = json.loads(decoded(data))
    except json.JSONDecodeError as error:
        raise MotionFileError(f"{file}, line {error.lineno}: {error.msg}. Export it again, or mend the line") from None
    except (RecursionError, ValueError):  # also for an integer without end
        raise MotionFileError(f"{file}: it is no list of frames. Export it again") from None
    parts = {folded(key): part for key, part in whole.items()} if isinstance(whole, dict) else {}
    frames, names = _first(parts, FRAMES) if parts else whole, _first(parts, NAMES)
    if not isinstance(frames, list) or not frames:
        raise MotionFileError(
            f'{file}: it has no frames. Give it a list of {{"name": value}}, or {{"names": [...], "frames": [...]}}'
        )
    rate_hz = rate_hz or _rate(_first(parts, RATES))
    stamps, label = [""] * len(frames), ""
    if names is None:
        if not all(isinstance(frame, dict) for frame in frames):
            fail(next(row for row, frame in enumerate(frames) if not isinstance(frame, dict)), "it has no names")
        found = [{folded(key): part for key, part in frame.items()} for frame in frames]
        label = next((key for key in TIMES if key in found[0]), "")
        stamps = [str(each.get(label, "")) for each in found]
        frames = [_nested(frame) for frame in frames]
        names = list(dict.fromkeys(key for frame in frames for key in frame if folded(key) not in NO_VALUES))
        frames = [[frame.get(name) for name in names] for frame in frames]
    if not isinstance(names, list) or not names or not all(isinstance(name, str) for name in names):
        raise MotionFileError(f"{file}: it has no names of shapes. Export it again")
    for row, frame in enumerate(frames):
        if not isinstance(frame, list) or len(frame) != len(names):
            fail(row, f"it does not have {len(names)} values, as there are names")
        for name, value in zip(names, frame, strict=True):
            if value is not None and number_of(value) is None:
                fail(row, f"the value of {quoted(name)} is no number")
    rows = [[math.nan if value is None else float(value) for value in frame] for frame in frames]
    return _made(names, rows, stamps, label, rate_hz, fail)


def number_of(value):
    """A value that JSON has as a number, else None."""
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return float(value) if is_number and abs(value) <= LARGEST_VALUE else None


def _rate(value):
    """Of a file, None where it makes no sense."""
    number = number_of(value)
    return number if number is not None and number > 0.0 else None


def _first(parts, keys):
    return next((parts[key] for key in keys if key in parts), None)


def _nested(frame):
    """What of a frame has the values: itself, or a dict in it."""
    return next((part for key, part in frame.items() if folded(key) in NESTED and isinstance(part, dict)), frame)


def _cells(lines, number, line, delimiter):
    try:
        return next(csv.reader([line], delimiter=delimiter))
    except csv.Error:
        lines.fail("it is no line of text", number=number)


def _number(lines, number, cell, name):
    cell = cell.strip()
    value = number_in(cell) if cell else math.nan
    if value is None or abs(value) > LARGEST_VALUE:
        lines.fail(f"{quoted(cell)} is no number, in column {quoted(name)}", number=number)
    return value


def _made(names, rows, stamps, label, rate_hz, fail):
    """The RecordedValues of rows with `stamps` in a column `label`. fail(row, reason) raises."""
    label, values = folded(label), np.array(rows, np.float64)
    if not any(stamps):
        times = np.arange(len(rows), dtype=np.float64)
    elif any(":" in stamp for stamp in stamps):
        times, rate_hz = _of_timecodes(stamps, rate_hz, fail)
    else:
        times = np.array([_number_of_stamp(row, stamp, fail) for row, stamp in enumerate(stamps)])
        if "frame" not in label and "index" not in label:
            rate_hz = rate_hz or 1000.0
            times *= rate_hz / (1000.0 if label.endswith(("ms", "milliseconds")) else 1.0)
    times = times - times[0]
    steps = np.diff(times)
    if (steps < 0.0).any():
        fail(int(np.argmax(steps < 0.0)) + 1, "its time is before that of the row above")
    is_new = np.append(True, steps > 0.0)
    doubles = wording.counted(int((~is_new).sum()), "row")
    notes = () if is_new.all() else (f"{doubles} with the time of the row above left out",)
    return RecordedValues(tuple(names), values[is_new], times[is_new], rate_hz, notes)


def _number_of_stamp(row, stamp, fail):
    number = number_in(stamp)
    if number is None or not abs(number) <= LARGEST_TIME:
        fail(row, f"{quoted(stamp)} is no time")
    return number


def _of_timecodes(stamps, rate_hz, fail):
    """(frames, their rate) of "hours:minutes:seconds:frames", the frames perhaps with a fraction."""
    parts = []
    for row, stamp in enumerate(stamps):
        found = [number_in(part) for part in stamp.replace(";", ":").split(":")]
        if len(found) not in (3, 4) or not all(part is not None and 0.0 <= part < 1e6 for part in found):
            fail(row, f"{quoted(stamp)} is no timecode (hours:minutes:seconds:frames)")
        parts.append(found if len(found) == 4 else [*found, 0.0])
    parts = np.array(parts)
    highest = math.floor(parts[:, 3].max())
    rate_hz = rate_hz or next((rate for rate in RATES_OF_TIMECODES if rate > highest), highest + 1)
    seconds = parts[:, :3] @ [3600.0, 60.0, 1.0]
    seconds += DAY_SECONDS * np.cumsum(np.append(0.0, np.diff(seconds)) < -0.5 * DAY_SECONDS)  # past midnight
    return seconds * rate_hz + parts[:, 3], float(rate_hz)
