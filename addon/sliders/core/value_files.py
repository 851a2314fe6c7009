# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads files of shape values by name, as recorders of faces write them: tables and JSON. Either becomes records,
{name: cell} of a frame each, of which value_columns.py makes values and times."""

import csv
import re

from ...capture.core.readers import format_of, read_by
from ...capture.core.records import of_json, plain
from ...capture.core.text_lines import REMEDY, Lines, decoded, number_in, quoted
from ...errors import MotionFileError
from .value_columns import made

WANTED_CSV = "Give it a first line of names (time,jawOpen,browInnerUp) and a line of numbers for each frame"
WANTED_JSON = 'Give it [{"time": 0.0, "jawOpen": 0.2}, ...], one a line, or {"fps": 60, "jawOpen": [0.2, ...]}'

#: Of a line of iFacialMocap: a shape and its value in percent. Frames a second that it sends.
PAIR, PAIRS_HZ = re.compile(r"([A-Za-z]\w*)[-&](-?\d+(?:\.\d+)?)(?:\||$)"), 60.0

SUFFIXES = (".csv", ".tsv", ".txt", ".json", ".jsonl", ".ndjson")


def read(path, rate_hz=None):
    """The RecordedValues of a file. rate_hz: frames a second of the recording; None: as the file tells. @throws
    MotionFileError with the file's name, the line and a remedy."""
    return read_by(parse, SUFFIXES, path, rate_hz)


def parse(data, file, rate_hz=None):
    """As read(), of bytes: their beginning tells the format."""
    if format_of(data) or data.startswith(b"Format Version"):
        raise MotionFileError(f"{file}: this is motion capture of a body. Use Import Motion Capture for it")
    return (parse_json if re.match(r"\s*[\[{]", decoded(data[:4096])) else parse_csv)(data, file, rate_hz)


def parse_csv(data, file, rate_hz=None):
    """Of bytes: a header with names, and rows; or name-percent|name-percent in each. As read()."""
    lines = Lines(data, file)
    if PAIR.match(decoded(data[:4096])):
        records = [{name: 0.01 * float(share) for name, share in PAIR.findall(line)} for _, line in lines.filled()]
        return made(records, rate_hz or PAIRS_HZ, lambda reason, row=None: lines.fail(reason, number=(row or 0) + 1))
    head, first, delimiter = _header(lines)
    records = [plain(dict(zip(head, first, strict=True)))] if first else []
    numbers = [lines.number] if first else []
    twice = next((name for place, name in enumerate(head) if name and name in head[:place]), None)
    if twice is not None:
        lines.fail(f"two columns are called {quoted(twice)}")
    for line_number, line in lines.filled():
        cells = _cells(lines, line_number, line, delimiter)
        if len(cells) < len(head) and lines.is_cut_off(line_number):
            break
        if len(cells) < len(head) or any(cell.strip() for cell in cells[len(head) :]):
            lines.fail(f"it has {len(cells)} columns where the header has {len(head)}", number=line_number)
        records.append(plain(dict(zip(head, cells, strict=False))))
        numbers.append(line_number)
    if not records:
        lines.fail("there is no whole row after the header", WANTED_CSV)

    def refuse(reason, row=None):
        lines.fail(reason, *((WANTED_CSV, 1) if row is None else (REMEDY, numbers[row])))

    return made(records, rate_hz, refuse)


def parse_json(data, file, rate_hz=None):
    """Of bytes: frames by name, wherever they are in the file. As read()."""

    def refuse(reason, row=None):
        where, remedy = ("", WANTED_JSON) if row is None else (f", frame {row + 1} of the file", "Export it again")
        raise MotionFileError(f"{file}{where}: {reason}. {remedy}")

    records, told_hz = of_json(data, file, refuse)
    return made(records, rate_hz or told_hz, refuse)


def _header(lines):
    """(names, the first row if it was read to find these, else None, what separates cells)."""
    line, told, comment = lines.next_filled(), None, ""
    while line is not None and (before := re.match(r'"?sep=(.)|#|info,', line, re.IGNORECASE)):
        comment, told = line.lstrip("# ") if line.startswith("#") else comment, before[1] or told
        line = lines.next_filled()
    if line is None:
        lines.fail("the file is empty", WANTED_CSV, number=1)
    delimiter = told or max(",;\t ", key=lambda each: (line.count(each) > 0, each != " ", line.count(each)))
    head = [cell.strip() for cell in _cells(lines, lines.number, line, delimiter)]
    if head[0] == "bs":  # of Face Cap, whose rows have a mark, the time, head and eyes before the shapes
        return ["", "time ms", *[""] * 10, *head[1:]], None, delimiter
    if 2 * sum(number_in(name) is not None for name in head) <= len(head):
        return head, None, delimiter
    names = [cell.strip() for cell in _cells(lines, lines.number, comment, delimiter)]
    if len(names) != len(head):  # numbers already, and the last comment does not name them
        lines.fail("it has no names of shapes", WANTED_CSV)
    return names, head, delimiter


def _cells(lines, line_number, line, delimiter):
    try:
        return next(csv.reader([line], delimiter=delimiter))
    except csv.Error:
        lines.fail("it is no line of text", number=line_number)
