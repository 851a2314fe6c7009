# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads TRC files (Motion Analysis, OpenSim): a table of markers in text.

Line 1 names the format, 2 and 3 are keys and values, 4 the labels, one every three columns, 5 the coordinates' names;
then a row for each frame, with its number and time before the coordinates. Blank cells are missing samples.
"""

from __future__ import annotations

import math
from array import array

import numpy as np

from ...errors import MotionFileError
from . import model_outputs, units
from .recording import Recording
from .take import Take
from .text_lines import Lines, number_in, quoted

RATE_WITHOUT = 100.0
AGAIN = "Export it again as TRC, or mend the line in a text editor"


def read(data: bytes, file: str, up_axis: str | None = None, unit: float | None = None) -> Take:
    """The physical markers of a TRC file of that content; `file` is its name. Raises MotionFileError."""
    lines = Lines(data)
    keys = _keys(lines, file)
    labels = _labels(lines, keys, file)
    notes = []
    table, nameless = _table(lines, file, len(labels), keys, notes)
    if nameless:
        notes.append(f"Rows have more columns than the {len(labels)} names need: {nameless} points have no name")
        labels += [""] * nameless
    rate = _rate(keys, table[:, 1], notes)
    numbered = table[0, 0]
    positions = table[:, 2:].reshape(len(table), len(labels), 3)
    kinds = [kind if kind == model_outputs.VIRTUAL else None for kind in map(model_outputs.kind_by_name, labels)]
    model_outputs.require_markers(kinds, file)
    chosen = [point for point, kind in enumerate(kinds) if kind is None]
    return Recording(
        file=file,
        rate_hz=rate,
        first_frame=int(numbered) if abs(numbered) < 2**31 else 1,
        labels=[labels[point] for point in chosen],
        positions=positions[:, chosen],  # a copy: it is written to
        unit=_unit(keys, notes),
        usual_up=("Y", "as OpenSim and most TRC files have it"),
        left_out=model_outputs.by_kind(labels, kinds),
        notes=notes,
    ).take(up_axis, unit)


def _keys(lines, file):
    """The header's values by their keys in lower case."""
    first = lines.next()
    if first is None or not first.lower().startswith("pathfiletype"):
        raise MotionFileError(
            f"{file}: this is no TRC file: its first line is {quoted(first or '')} and should begin with "
            "'PathFileType'. Choose the file that the capture system exported"
        )
    names, values = lines.next(), lines.next()
    if names is None or values is None:
        raise MotionFileError(f"{file}: it ends in its header, at line {lines.number}. {AGAIN}")
    return dict(zip((name.lower() for name in names.split()), values.split(), strict=False))


def _labels(lines, keys, file):
    """One label for each marker; empty ones stay empty."""
    line = lines.next_filled()
    if line is None or not line.lower().lstrip().startswith("frame"):
        raise MotionFileError(
            f"{file}, line {lines.number}: the markers' names are missing, a line that begins with 'Frame#'. {AGAIN}"
        )
    cells = [cell.strip() for cell in line.split("\t")]
    told = number_in(keys.get("nummarkers", ""))
    columns = lines.next_filled() or ""
    labels = cells[2::3]
    while labels and not labels[-1]:
        labels.pop()
    named = [cell for cell in cells[2:] if cell]
    if told is not None and len(labels) != told:
        if len(named) == told:  # the names follow each other without the two empty cells between them
            labels = named
        elif len(line.split()) - 2 == told:
            labels = line.split()[2:]
        elif len(labels) < told <= len(columns.split()) // 3:
            labels += [""] * (int(told) - len(labels))
    if not labels:
        raise MotionFileError(f"{file}, line {lines.number}: it names no marker. Export the take with its markers")
    return labels


def _table(lines, file, markers, keys, notes):
    """((f, 2 + 3 m) float64: number of the frame, time, coordinates, NaN for blank cells; how many of the m the header
    has no names for, though the first row has columns for them)."""
    rows = [(lines.number, line) for line in lines if line.strip()]
    told = number_in(keys.get("numframes", ""))
    told = int(told) if told is not None and math.isfinite(told) else None
    if not rows:
        raise MotionFileError(f"{file}: it has no frames after its header. {AGAIN}")
    width = max(2 + 3 * markers, len(_cells(rows[0][1], 2 + 3 * markers)))
    nameless = -(-(width - 2) // 3) - markers
    width = 2 + 3 * (markers + nameless)
    if len(rows) * width > 16 * sum(len(line) + 64 for _, line in rows):  # short rows must not fill the memory
        raise MotionFileError(
            f"{file}, line {rows[0][0]}: the rows are much shorter than the {width // 3} markers in the header need. "
            f"{AGAIN}"
        )
    if told is not None and len(rows) <= told and not lines.ends_whole and len(_cells(rows[-1][1], width)) < width:
        rows.pop()
    values = array("d")
    for number, line in rows:
        cells = _cells(line, width)
        if len(cells) > width or ("\t" not in line and len(cells) != width):
            raise MotionFileError(
                f"{file}, line {number}: it has {len(cells)} columns, and {width // 3} markers need {width}. {AGAIN}"
            )
        try:
            values.extend([float(cell.strip() or "nan") for cell in cells])
        except ValueError:
            wrong = next(cell for cell in cells if cell.strip() and number_in(cell) is None)
            raise MotionFileError(f"{file}, line {number}: {quoted(wrong)} is no number. {AGAIN}") from None
        values.extend([math.nan] * (width - len(cells)))
    if not rows:
        raise MotionFileError(f"{file}: it has no frames after its header. {AGAIN}")
    if told is not None and told != len(rows):
        what = "is cut off" if len(rows) < told else "is longer than it says"
        notes.append(f"The file {what}: {len(rows)} frames are there, {told} are told")
    table = np.frombuffer(values, np.float64).reshape(len(rows), width)
    if np.isnan(table[0, 0]):
        raise MotionFileError(f"{file}: its first row has no frame number. {AGAIN}")
    return table, nameless


def _cells(line, width):
    """Those of a row; blank ones beyond `width` are none."""
    cells = line.rstrip("\r").split("\t") if "\t" in line else line.split()
    while len(cells) > width and not cells[-1].strip():
        cells.pop()
    return cells


def _rate(keys, times, notes):
    for key in ("datarate", "camerarate"):
        rate = number_in(keys.get(key, ""))
        if rate is not None and math.isfinite(rate) and 1e-3 <= rate <= 1e6:
            return rate
    with np.errstate(all="ignore"):
        step = float(np.median(np.diff(times))) if len(times) > 1 else math.nan
    if math.isfinite(step) and 1e-6 <= step <= 1e3:
        notes.append(f"The header names no usable rate: {1.0 / step:.6g} frames a second by the times of the rows")
        return 1.0 / step
    notes.append(f"The file names no usable rate: {RATE_WITHOUT:g} frames a second are assumed")
    return RATE_WITHOUT


def _unit(keys, notes):
    name = keys.get("units", "")
    metres = units.metres_in(name)
    if name and metres is None:
        notes.append(f"The file's unit {quoted(name)} is not known")
    return metres
