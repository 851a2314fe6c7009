# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads files of shape values by name, as recorders of faces write them: tables, and JSON in any order of its parts.
Either becomes records, {name: cell} of a frame each, of which value_columns.py makes values and times."""

import collections
import csv
import functools
import json
import re

from ...capture.core.readers import format_of, read_by
from ...capture.core.text_lines import REMEDY, Lines, decoded, number_in, quoted
from ...capture.core.time_columns import folded, number
from ...errors import MotionFileError
from .value_columns import made

WANTED_CSV = "Give it a first line of names (time,jawOpen,browInnerUp) and a line of numbers for each frame"
WANTED_JSON = 'Give it [{"time": 0.0, "jawOpen": 0.2}, ...], one a line, or {"fps": 60, "jawOpen": [0.2, ...]}'

#: Names, as folded() has them: of a name beside a score, of that score, and of frames a second.
LABEL, SCORES = re.compile("name|shape|label|key|^k$"), {"score", "value", "weight", "values", "v"}
RATE, LARGEST_RATE = re.compile("fps|persecond|^(frame|sampl[a-z]+|recording|capture)?rate$"), 1000.0

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
    """Of bytes: a header with names, and rows. As read()."""
    lines = Lines(data, file)
    head, first, delimiter = _header(lines)
    records = [_plain(dict(zip(head, first, strict=True)))] if first else []
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
        records.append(_plain(dict(zip(head, cells, strict=False))))
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

    try:
        whole = _loaded(decoded(data), file)
        names, records = {}, collections.defaultdict(dict)
        for key, part in _heads(whole):
            if RATE.search(folded(key)) and 1.0 <= number(part) <= LARGEST_RATE:
                rate_hz = rate_hz or number(part)
            if isinstance(part, list) and part and all(isinstance(each, str) and each[:1].isalpha() for each in part):
                names[len(part)] = part
        _gather(whole, records, names, refuse)
        if not records:
            _gather([whole], records, names, refuse, row=0)  # one frame
    except (RecursionError, ValueError):  # also for an integer without end
        refuse("it is no list of frames")
    return made([records[row] for row in range(max(records, default=-1) + 1)], rate_hz, refuse)


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


def _loaded(text, file):
    """What a JSON text has; a list where it has several, as an object a line. The last of them may be cut off."""
    found, decoder, between = [], json.JSONDecoder(), re.compile(r"[\s,]*")
    at = between.match(text).end()
    while at < len(text):
        try:
            part, at = decoder.raw_decode(text, at)
        except json.JSONDecodeError as error:
            if found and isinstance(found[-1], dict) and "\n" not in text[at:]:
                break
            raise MotionFileError(f"{file}, line {error.lineno}: {error.msg}. {REMEDY}") from None
        found.append(part)
        at = between.match(text, at).end()
    return found[0] if len(found) == 1 else found


def _heads(node, key=""):
    """(key, part) of a JSON value, of all in its objects and of the first in its lists."""
    yield key, node
    parts = {key: node[0]} if isinstance(node, list) and node else node if isinstance(node, dict) else {}
    for each, part in parts.items():
        yield from _heads(part, each)


def _gather(node, records, names, refuse, key="", row=None):
    """Puts all of a JSON value, whose outermost list has the rows, into `records`. names: {number: so many names}."""
    if isinstance(node, dict) and row is None and node and all(number_in(each) is not None for each in node):
        node = [{"": each, **part} for each, part in node.items() if isinstance(part, dict)]  # numbered frames
    if isinstance(node, list) and ((len(node) == 1 and isinstance(node[0], dict)) or node == names.get(len(node))):
        node = node[0]
    if isinstance(node, list) and row is None:
        first = next((_kind(part) for part in node if part), None)
        for place, part in enumerate(node):
            if part and _kind(part) != first:
                refuse("it is not like the first one", place)
            _gather(part, records, names, refuse, key, place)
    elif isinstance(node, list):
        named = _kind(node) in names
        for name, part in zip(names[len(node)] if named else [key] * len(node), node, strict=True):
            if named or isinstance(part, (dict, list)):
                _gather(part, records, names, refuse, name, row)
    elif isinstance(node, dict):
        plain = _plain(node)
        if plain is not node and any(isinstance(part, list) and _kind(part) not in names for part in plain.values()):
            row = None  # the list of a shape
        for name, part in plain.items():
            _gather(part, records, names, refuse, name, row)
    elif row is not None:
        records[row].setdefault(key, node)


def _kind(node):
    """What the items of a list have in common: flat lists the number of what they have."""
    if isinstance(node, list):
        return list if any(isinstance(part, (dict, list)) for part in node) else len(node)
    return type(node) if isinstance(node, dict) else None


def _plain(node):
    """An object; where it has a name beside a score, the score is by that name."""
    labels, score, others = _roles(tuple(node))
    label = (
        next(filter(str.strip, (node[key] for key in labels if isinstance(node[key], str))), None) if score else None
    )
    if label is None:
        return node
    kept = (*others, *(key for key in labels if not isinstance(node[key], str)))
    return {key: node[key] for key in kept} | {label: node[score]}


@functools.lru_cache(4096)
def _roles(keys):
    """Of the keys of an object: ([those of names], that of a score or "", [the others])."""
    score = next((key for key in keys if folded(key) in SCORES), "")
    labels = [key for key in keys if LABEL.search(folded(key)) and key != score]
    return labels, score, [key for key in keys if key not in (*labels, score) and folded(key) != "index"]
