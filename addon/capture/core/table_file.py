# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads tables of points, as Motive, Nexus, Qualisys and trackers of videos write them: CSV, TSV, TRC and JSON.

Columns that are called alike but for X, Y and Z are a point. Their names stand in one row ("nose_x"), or in several
above the axes. Rows with a name, X, Y and Z are a point each. In TRC (Motion Analysis, OpenSim) line 1 names the
format, 2 and 3 are keys and values, 4 the names, one every three columns, 5 the axes; then a row for each frame.
"""

import collections
import csv
import itertools
import math
import re
from array import array

import numpy as np

from ... import wording
from . import marker_sets, records, time_columns, units
from .recording import Recording, Take, usable_rate
from .text_lines import Lines, decoded, number_in, quoted

_UNITS = "|".join(sorted(units.METRES, key=len, reverse=True))
#: The name of a column: of which point, along which axis, in which unit; or the axis before a number.
AXIS = re.compile(rf"(.*?)[\s_.:\-\[(]*([xyz])[\])]*(?:[\s_(\[]+({_UNITS})[)\]]*)?|([xyz])_?(\d+)", re.I)
#: The end of that of the point: a place, or what is none.
PLACE = re.compile(r"(?:(.*)[\s_.:\-])?(?:pos(?:ition)?s?|trans(?:lation)?|loc(?:ation)?|coord(?:inate)?s?)", re.I)
OTHER = re.compile(r"(?:(.*)[\s_.:\-])?(?:(?:rot|orient)(?:ation)?|q(?:uat\w*)?|euler|\w*acc\w*|vel\w*|ang\w*)", re.I)
#: A cell of a row of axes; of these "rx" and "w" are of turns.
ALONE = re.compile(r"t?([xyz])\d*|(?:r[xyz]|w)()", re.I)
#: In a header: frames a second, also alone in a line; the unit.
RATE = re.compile(r"(export )?(?:(?:frame|data|sampl\w*) ?rate|frequency|fps)\W{1,4}([\d.]+)|^([\d.]+),*$", re.I | re.M)
UNIT = re.compile(r"units?\W{1,4}(\w+)", re.I)
#: Rows that are looked at for a header; what Motive has beside markers.
HEADER, SOLVED = 60, {"Bone": "bones", "Rigid Body": "rigid bodies"}
NO_POINT = "no part of it is a point with X, Y and Z (what recorders of faces write is for Import Shape Key Values)"
REMEDY = "Export it with X, Y and Z of each point, or as C3D, TRC or BVH"
#: Share of the usual time between frames by which usual ones differ; frames for one that is written, at most.
UNEVEN, SPARSE = 0.3, 4


def read(data: bytes, file: str, up_axis: str | None = None, unit: float | None = None) -> Take:
    """The points of a table, or in JSON, of that content; `file` is its name. Raises MotionFileError."""
    lines = Lines(data, file)
    try:
        begins = decoded(data[:4096])
        if is_trc := begins.lstrip().startswith("PathFileType"):
            points, others, known, rows = _of_trc(lines)
        elif re.match(r"\s*[\[{]", begins):
            head, rows, width = _of_records(*records.of_json(data, file, lambda why, *_: lines.fail(why, REMEDY, 1)))
        else:
            head, rows, width = _split(lines)
            names = [cell.casefold() for cell in head[-1]]
            is_named = any(records.LABEL.search(time_columns.folded(name)) for name in names)
            if is_named and {"x", "y", "z"} <= set(names) and len(set(names)) == len(names):
                head, rows, width = _of_records([records.plain(dict(zip(names, row, strict=False))) for _, row in rows])
        if not is_trc:
            points, others, known = _columns(lines, head, width)
        positions, cells, numbers = _numbers(lines, rows, list(itertools.chain(*points.values())), others)
        if not len(positions):
            lines.fail(NO_POINT, REMEDY, number=1)
    except csv.Error:  # of a quote that nothing ends
        lines.fail("it is no table", REMEDY, number=1)
    if len(positions) < (told := known.pop("frames")):
        known["notes"].append(f"The file is cut off: {len(positions)} of its {told:g} frames are there")
    labels = [label for label, *_ in points]
    if labels == [str(number) for number in range(len(labels))]:
        labels = marker_sets.NUMBERED.get(len(labels), labels)
    positions = _in_time(positions, cells, known, lambda reason, row: lines.fail(reason, number=numbers[row]))
    return Recording(file=file, labels=labels, positions=positions, usual_rate=30.0, **known).take(up_axis, unit)


def _in_time(positions, columns, known, refuse):
    """Positions (f, m, 3) at an even rate, by the one of columns, {name: f cells}, that is the time; rate, start and
    notes go to `known`, which may have a rate."""
    rate = known["rate_hz"]
    clocks = [time_columns.clock_of(name, cells, rate, refuse) for name, cells in columns.items()]
    clock = time_columns.the_time(filter(None, clocks), len(positions), None)
    times, steps = clock.times - clock.times[0], np.diff(clock.times)
    if not clock.words or not len(steps) or not (steps > 0.0).all():
        return positions
    middle = np.sort(steps)[len(steps) // 2]
    usual = float(steps[np.abs(steps / middle - 1.0) < UNEVEN].mean())  # many are rounded
    known["rate_hz"] = rate or (clock.rate_hz and usable_rate(clock.rate_hz / usual))
    known["start_s"] = time_columns.number(columns[clock.name][0]) if clock.words == "seconds" else 0.0
    times = np.round(times / usual, 6)
    if not 0.5 < np.abs(times - np.arange(len(times))).max() < SPARSE * len(times):
        return positions
    known["notes"].append("Frames are not evenly spaced in time: points go in lines between them")
    wanted = np.arange(math.floor(times[-1] + 0.5) + 1).clip(max=times[-1])
    columns = np.where(positions.any(axis=2, keepdims=True), positions, np.nan).reshape(len(times), -1).T
    return np.column_stack([np.interp(wanted, times, column) for column in columns]).reshape(len(wanted), -1, 3)


def _split(lines):
    """(rows of cells above the numbers, iterator of (line number, cells) of these, how many cells), of the trajectories
    if the file has more."""
    text = list(lines)
    delimiter = next((each for each in "\t;," if each in max(text[:HEADER], key=len, default="")), " ")
    begin = next((at for at, line in enumerate(text) if line.rstrip(f" {delimiter}") == "Trajectories"), 0)
    reader = csv.reader(text[begin:], delimiter=delimiter, skipinitialspace=True)
    cells = ([cell.strip() for cell in row] for row in reader)
    head = list(itertools.islice(cells, HEADER))
    shares = [*map(_share, head), 1.0]
    start = next((at for at, row in enumerate(head) if sum(map(bool, row)) > 1 and min(shares[at : at + 2]) > 0.5), 0)
    above = [row for row in head[:start] if any(row)]
    if not above:
        lines.fail("it has no names above rows of numbers", REMEDY, number=1)
    rows = enumerate(itertools.chain(head[start:], cells), begin + start + 1)
    return above, rows, len(head[start])


def _of_trc(lines):
    """As _columns(), and the rows."""
    _, keys, values = [*itertools.islice(lines, 3), "", ""][:3]
    keys, told = keys.lower().split(), _cells(values)
    told = told if len(told) <= len(keys) else values.split()  # some write two tabs between values
    told = collections.defaultdict(str, zip(keys, told, strict=False))
    names = [cell.strip() for cell in _cells(lines.next_filled() or "")[2:]]
    names = [*filter(None, names)] if any(names[1::3]) else names[::3]  # some leave out the two empty cells after each
    text = lines.filled()
    text = text[1:] if text and _share(_cells(text[0][1])) < 0.5 else text
    nameless = max(0, (max((len(_cells(line)) for _, line in text), default=0) - 2) // 3 - len(names))
    notes = [f"Rows have more columns than the {len(names)} names need: {nameless} points have no name"]
    notes, names = notes if nameless and names else [], names + [""] * nameless
    if not names or not text:
        lines.fail("neither the header nor a row has a marker", "Export the take with its markers")
    for number, line in text:
        if (width := len(_cells(line))) > 2 + 3 * len(names):
            lines.fail(f"it has {width} numbers where there must be {2 + 3 * len(names)}", number=number)
    known = {"rate_hz": usable_rate(*(number_in(told[key]) for key in ("datarate", "camerarate"))),
             "frames": number_in(told["numframes"]) or 0.0, "unit": told["units"], "kinds": marker_sets.kinds(names),
             "usual_up": ("Y", "as OpenSim and most TRC files have it"), "notes": notes}  # fmt: skip
    points = {(name, "", place): [*range(2 + 3 * place, 5 + 3 * place)] for place, name in enumerate(names)}
    return points, {"frame": 0, "time": 1}, known, ((number, _cells(line)) for number, line in text)


def _cells(line):
    """What stands between tabs or, without any, between blanks; without blank cells at the end."""
    return line.rstrip().split("\t") if "\t" in line else line.split()


def _of_records(found, rate_hz=None):
    """As _split(), of records, {name: cell}, of which those of one time are one row if no point is there twice."""
    rows = {}
    for number, record in enumerate(found):
        time = tuple(cell for name, cell in record.items() if time_columns.CLOCK.search(time_columns.folded(name)))
        points = {name for name in record if name.endswith("_x")}
        key = number if not points or points & rows.get(time, {}).keys() else time
        rows.setdefault(key, {}).update(record)
    if all(isinstance(key, tuple) for key in rows):
        rows = dict(sorted(rows.items(), key=lambda row: [*map(time_columns.number, row[0])]))
    names = [*dict.fromkeys(name for row in rows.values() for name in row)]
    seen = [number for number, row in enumerate(rows.values()) if any(name.endswith("_x") for name in row)] or [0]
    cells = [["" if row.get(name) is None else str(row[name]) for name in names] for row in rows.values()]
    return [["fps", str(rate_hz)], names], enumerate(cells[seen[0] : seen[-1] + 1], seen[0] + 1), len(names)


def _share(cells):
    """Of the cells that are not blank, the share of numbers; 1 without any."""
    filled = [cell for cell in cells if cell]
    return sum(number_in(cell.replace(",", ".")) is not None for cell in filled) / len(filled) if filled else 1.0


def _columns(lines, head, width):
    """({(label, type, count): columns of X, Y and Z}, {name: column} of the others, what a Recording is told)."""
    rows, blank = [(cells + [""] * width)[:width] for cells in head], [""] * width
    keyed = {cell.casefold(): row for row in reversed(rows) for cell in row[1::-1]}
    axes = next((at for at in range(len(rows) - 1, 0, -1) if sum(map(bool, map(ALONE.fullmatch, rows[at]))) > 2), 0)
    listed = [cell for cell in keyed.get("marker_names", ())[1:] if cell]
    if axes:
        whats, lengths = rows[axes - 1], rows[axes + 1] if axes + 1 < len(rows) else blank
        found = _stacked(keyed.get("name", whats), whats if "name" in keyed else blank, rows[axes], lengths)
    elif listed and rows[-1][0].isupper():
        before = ("Frame", "Time")[: 2 * (width - 3 * len(listed) > 1)]
        found = [*((name, "", "", "") for name in before), *((name, "", axis, "") for name in listed for axis in "xyz")]
    else:
        found = map(_parsed, max(rows, key=lambda row: sum(map(bool, row))))
    points, units_of, others, turned, unnamed = {}, {}, {}, {}, 0
    for at, ((name, what, axis, length), kind) in enumerate(zip(found, keyed.get("type", blank), strict=False)):
        if not axis:
            others.setdefault(name, at)
        elif OTHER.fullmatch(what):
            turned[name] = at
        else:
            unnamed += not name and axis == "x"
            key = name, kind, 0 if name else unnamed
            points.setdefault(key, {}).setdefault(axis, at)
            units_of[key] = length
    whole = {key: [at[axis] for axis in "xyz"] for key, at in points.items() if len(at) == 3}
    if not whole:
        is_flat = any({"x", "y"} <= set(at) for at in points.values())
        what = f"it has rotations alone, of {wording.counted(len(turned), 'segment')}: {wording.quoted(turned)}"
        what = "its points have X and Y alone, as in a picture" if is_flat else what if turned else NO_POINT
        lines.fail(what, REMEDY, number=1)
    text = "\n".join(",".join(cells) for cells in head)
    rates = [number_in(one or other) for _, one, other in sorted(RATE.findall(text), key=lambda found: not found[0])]
    lengths = [units_of[key] for key in whole if units.metres_in(units_of[key])] or UNIT.findall(text)
    lengths = lengths or ["mm"] * text.startswith("NO_OF_FRAMES")  # Qualisys has no other
    known = {"rate_hz": usable_rate(*rates), "unit": (lengths or [""])[0], "notes": [], "frames": 0}
    if text.startswith("Format Version"):
        known["usual_up"] = "Y", "as Motive has it"
    types = {kind for _, kind, _ in whole}
    if "Bone" in types and not any(kind.endswith("Marker") for kind in types):
        known["is_skeleton"] = True
        return {key: at for key, at in whole.items() if key[1] == "Bone"}, others, known
    known["kinds"] = [_kind(key, types, whole, units_of[key]) for key in whole]
    return whole, others, known


def _stacked(names, whats, axes, lengths):
    """(name, what, axis, unit) of each column, by rows of these; blank names are that of the column before."""
    last = ""
    for name, what, axis, length in zip(names, whats, axes, lengths, strict=True):
        found = ALONE.fullmatch(axis)
        last = name or last
        yield (last, what, found[1].lower(), length) if found and found[1] else (axis or name, "", "", "")


def _parsed(cell):
    """(name, what, axis, unit) of a column by its name."""
    found = len(cell) < 200 and AXIS.fullmatch(cell)
    if not found:
        return cell, "", "", ""
    name, axis, unit = found[1] or found[5] or "", found[2] or found[4], found[3] or ""
    what = PLACE.fullmatch(name) or OTHER.fullmatch(name)
    return (what[1] or "" if what else name), (name[what.end(1) + 1 :] if what else ""), axis.lower(), unit


def _kind(key, types, points, unit):
    """What a point is if it is no marker, as marker_sets.kinds()."""
    label, kind, _ = key
    if unit and not units.metres_in(unit):
        return f"values in {unit}"
    if kind in SOLVED and len(types) > 1:
        return SOLVED[kind]
    is_twice = kind.endswith(" Marker") and (label, "Marker", 0) in points
    return "solved markers" if is_twice else marker_sets.kinds([label])[0]


def _numbers(lines, rows, columns, others):
    """((f, m, 3), {name: f cells} of other columns that may tell times, f numbers of their lines)."""
    values, numbers, cells = array("d"), [], {name: [] for name in others if time_columns.CLOCK.search(name.lower())}
    width = max(columns) + 1
    for number, row in rows:
        if any(row) and _share(row[:1]) == 0.0 == _share(row):
            break  # another table
        if not any(row) or (len(row) < width and lines.is_cut_off(number)):
            continue
        try:
            values.extend([float(row[at] or "nan") for at in columns])
        except (ValueError, IndexError):
            row += [""] * (width - len(row))
            found = [time_columns.number(row[at]) for at in columns]
            if math.inf in found:
                lines.fail(f"{quoted(row[columns[found.index(math.inf)]])} is no number", number=number)
            values.extend(found)
            if len(values) > 4 * lines.size + 1024 * number:  # short rows must not fill the memory
                lines.fail(f"the rows are much shorter than the {len(columns) // 3} points above them need")
        numbers.append(number)
        for name, into in cells.items():
            into.append(row[others[name]] if others[name] < len(row) else "")
    return np.frombuffer(values, np.float64).reshape(-1, len(columns) // 3, 3).copy(), cells, numbers
