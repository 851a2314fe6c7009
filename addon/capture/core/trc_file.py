# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads TRC files (Motion Analysis, OpenSim): a table of markers in text.

Line 1 names the format, 2 and 3 are keys and values, 4 the labels, one every three columns, 5 the coordinates' names;
then a row for each frame, with its number and time before the coordinates. Blank cells are missing samples.
"""

import math

import numpy as np

from . import marker_sets
from .recording import Recording, Take, usable_rate
from .text_lines import Lines, cells, number_in, quoted


def read(data: bytes, file: str, up_axis: str | None = None, unit: float | None = None) -> Take:
    """The physical markers of a TRC file of that content; `file` is its name. Raises MotionFileError."""
    lines = Lines(data, file)
    keys = _keys(lines)
    labels = _labels(lines, keys)
    notes = []
    table = _table(lines, labels, keys, notes)
    return Recording(
        file=file,
        rate_hz=_rate(keys, table[:, 1], notes),
        labels=labels,
        kinds=marker_sets.kinds(labels),
        positions=table[:, 2:].reshape(len(table), len(labels), 3),
        unit=keys.get("units", ""),
        usual_up=("Y", "as OpenSim and most TRC files have it"),
        notes=notes,
        start_s=float(np.nan_to_num(table[0, 1])),
    ).take(up_axis, unit)


def _keys(lines):
    """The header's values by their keys in lower case."""
    first = lines.next() or ""
    if not first.lower().startswith("pathfiletype"):
        lines.fail(
            f"this is no TRC file, which should begin with 'PathFileType' and begins with {quoted(first)}",
            "Choose the file that the capture system exported",
        )
    names, values = lines.next(), lines.next()
    if names is None or values is None:
        lines.fail("the file ends in its header")
    names, told = cells(names, 0), cells(values, 0)
    told = told if len(told) <= len(names) else values.split()  # some write two tabs between values
    return dict(zip((name.strip().lower() for name in names), told, strict=False))


def _labels(lines, keys):
    """One label for each marker; empty ones stay empty."""
    line = lines.next_filled() or ""
    if not line.lower().lstrip().startswith("frame"):
        lines.fail("the markers' names are missing, a line that begins with 'Frame#'")
    entries = [cell.strip() for cell in line.rstrip().split("\t")]
    told = number_in(keys.get("nummarkers", ""))
    columns = (lines.next_filled() if any(entries[2:]) else lines.next()) or ""  # of no names the cells are blank
    by_columns = entries[2::3]
    # Some writers leave out the two empty cells after a name, some the tabs.
    readings = (by_columns, [cell for cell in entries[2:] if cell], line.split()[2:])
    labels = next((reading for reading in readings if len(reading) == told), by_columns)
    if told is not None and len(labels) < told <= len(columns.split()) // 3:
        labels = labels + [""] * (int(told) - len(labels))
    return labels


def _table(lines, labels, keys, notes):
    """(f, 2 + 3 m) float64: number of the frame, time, coordinates, NaN for blank cells. Points that rows have beyond
    the labels are added to these without a name."""
    rows = lines.filled()
    told = number_in(keys.get("numframes", ""))
    told = int(told) if told is not None and math.isfinite(told) else None
    width = 2 + 3 * len(labels)
    nameless = max((len(cells(line, width)) - width for _, line in rows), default=0) // 3
    if nameless > 0 and labels:
        notes.append(f"Rows have more columns than the {len(labels)} names need: {nameless} points have no name")
    labels += [""] * nameless
    if not labels:
        lines.fail("neither the header nor a row has a marker", "Export the take with its markers")
    width = 2 + 3 * len(labels)
    if len(rows) * width > 16 * sum(len(line) + 64 for _, line in rows):  # short rows must not fill the memory
        lines.fail(f"the rows are much shorter than the {width // 3} markers in the header need")
    table = lines.table(rows, width, told, notes)
    if np.isnan(table[0, 0]):
        lines.fail("the first row has no frame number", number=rows[0][0])
    return table


def _rate(keys, times, notes):
    """Frames a second by the header, else by the times of the rows; None if neither is usable."""
    rate = usable_rate(*(number_in(keys.get(key, "")) for key in ("datarate", "camerarate")))
    if rate is None and len(times) > 1:
        with np.errstate(all="ignore"):
            rate = usable_rate(1.0 / np.median(np.diff(times)))
        if rate is not None:
            notes.append(f"The header names no usable rate: {rate:.6g} frames a second by the times of the rows")
    return rate
