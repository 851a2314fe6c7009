# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads files of shape values by name, as recorders of faces write them: tables and JSON. Either becomes records,
{name: cell} of a frame each, and these become values and times. And which names of shapes and keys mean the same."""

import collections
import csv
import re

import numpy as np

from ... import wording
from ...capture.core.readers import format_of, read_by
from ...capture.core.records import of_json, plain
from ...capture.core.text_lines import REMEDY, Lines, decoded, number_in, quoted
from ...capture.core.time_columns import clock_of, folded, numbers, the_time
from ...errors import MotionFileError, SceneError

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


#: A name, as folded() has it, of what counts values. One row of so many may be left out as its time goes back. What is
#: larger is no value of a shape.
COUNT, ROWS_PER_FALL, LARGEST_VALUE = "blendshapecount", 50, 1e6

#: names: s, as in the file; values: (f, s) float64, NaN where one is missing; times: (f,) float64 ascending from 0,
#: in frames of the recording; rate_hz: of them, or None: as the scene's; clock: a sentence on where the times are from;
#: notes: sentences on what was left out.
RecordedValues = collections.namedtuple("RecordedValues", "names values times rate_hz clock notes")


def made(records, rate_hz, refuse):
    """The RecordedValues of `records`, {name: cell} each. refuse(reason, row, or None for the whole file) raises."""
    clocks, columns, wordless = [], {}, []
    for name in dict.fromkeys(name for record in records for name in record):
        cells = [record.get(name) for record in records]
        clock = clock_of(name, cells, rate_hz, refuse)
        column = None if clock else numbers(cells, LARGEST_VALUE, f"no number, in column {quoted(name)}", refuse)
        if clock:
            clocks.append(clock)
        elif name and column is None:
            wordless.append(name)
        elif name and folded(name) != COUNT:
            columns[name] = column
    notes = [f"Without numbers, and left out: {wording.quoted(wordless)}"] if wordless else []
    if not columns:
        refuse(". ".join(["it has no names of shapes with numbers", *notes]))
    clock = the_time(clocks, len(records), rate_hz)
    kept = _in_order(clock.times, refuse, notes)
    times, values = _merged(clock.times[kept], np.column_stack(list(columns.values()))[kept], notes)
    rows = f"Each row is a frame, {rate_hz:g} a second" if rate_hz else "No time is there: each row is a frame"
    said = f"Time is {quoted(clock.name)}, in {clock.words}" if clock.words else rows
    return RecordedValues(tuple(columns), values, times - times[0], clock.rate_hz, said, tuple(notes))


def _in_order(times, refuse, notes):
    """(f,) bool: rows whose times do not go back, which are all but a few."""
    back, ahead = times < np.fmax.accumulate(times), times > np.fmin.accumulate(times[::-1])[::-1]
    out = min(back, ahead, key=np.count_nonzero) | np.isnan(times)
    if np.count_nonzero(out) > max(1, len(times) // ROWS_PER_FALL):
        reason = "its time is before that of the row above" if back.any() else "it has no time"
        refuse(reason, int(np.argmax(back if back.any() else out)))
    if out.any():
        rows = wording.counted(int(out.sum()), "row")
        notes.append(f"{rows} left out, whose time goes back or is missing: row {int(np.argmax(out)) + 1} first")
    return ~out


def _merged(times, values, notes):
    """(times, values) with rows of one time as one: the first value of each shape counts."""
    is_new = np.append(True, np.diff(times) > 0.0)
    merged, places, lost = values[is_new], np.cumsum(is_new) - 1, 0
    for row in np.flatnonzero(~is_new):
        into = merged[places[row]]
        lost += bool((~np.isnan(into) & ~np.isnan(values[row]) & (into != values[row])).any())
        into[:] = np.where(np.isnan(into), values[row], into)
    if lost:
        notes.append(f"{wording.counted(lost, 'row')} with the time of the row above left out")
    return times[is_new], merged


def matched(names, keys, given=""):
    """{name: key} of those of `names` that `keys` has: as `given`, else the same name, else one that folds alike,
    else one that folds as the end of the name does: blendShapes.JawOpen, morphTargetInfluences[jawOpen].

    given: "name=key; name=key; ..."; nothing behind = leaves a name out. No key has two names: the first counts.
    @throws SceneError for what is given and not there.
    """
    wanted = _given(given, names, keys)
    found = {name: key for name, key in wanted.items() if key}
    for simple in SIMPLER:
        alike = {}
        for key in keys:
            alike.setdefault(simple(key), key)
        for name in names:
            key = alike.get(simple(name))
            if name not in wanted and name not in found and key is not None and key not in found.values():
                found[name] = key
    return found


def _given(text, names, keys):
    """{name: key or ""}."""
    found = {}
    for entry in filter(None, map(str.strip, text.split(";"))):
        name, equals, key = (part.strip() for part in entry.partition("="))
        if not equals:
            raise SceneError(f"'{entry}' is no pair of names. Write name=key, and a semicolon between pairs")
        of_file, of_mesh = _named(name, names), _named(key, keys)
        if of_file is None:
            raise SceneError(f"The file has no values of '{name}'. It has {wording.quoted(names, limit=12)}")
        if key and of_mesh is None:
            raise SceneError(f"The mesh has no shape key '{key}' for '{name}'. Give the name of one that it has")
        found[of_file] = of_mesh or ""
    return found


def _named(name, names):
    """The one of `names` that means `name`, or None."""
    return next((each for simple in SIMPLER for each in names if simple(each) == simple(name)), None)


#: Names that mean the same are alike by one of these, the first before the next.
SIMPLER = (str, folded, lambda name: folded(re.split(r"[.:|\[]", name.rstrip("]"))[-1]))
