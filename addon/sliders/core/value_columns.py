# SPDX-License-Identifier: GPL-3.0-or-later
"""What records of a file are: values of shapes by name, at times. Names and numbers tell which column is the time,
and which names of shapes and shape keys mean the same."""

import collections
import functools
import math
import re

import numpy as np

from ... import wording
from ...capture.core.text_lines import quoted
from ...errors import SceneError

#: Names, as folded() has them, of what may be a time, and of what counts values.
CLOCK, COUNT = re.compile(r"time|stamp|clock|elapsed|frame|ms$|sec(ond)?s?$|^t?s?$"), "blendshapecount"
BLANK = {"", "none", "null", "na", "n/a", "-"}

#: Hours, minutes, seconds and frames, the last two perhaps with a fraction; a date before them, a zone behind them.
TIMECODE = re.compile(
    r"(?:.*[T ])?(\d{1,6}):(\d\d?):(\d\d?(?:[.,]\d+)?)(?:[:;](\d{1,6}(?:\.\d+)?))?(?:Z|[+-]\d\d:?\d\d)?", re.ASCII
)

#: What the frames in a timecode may count, in a second; the last are milliseconds.
RATES_OF_TIMECODES = (24, 25, 30, 48, 50, 60, 100, 120, 240, 1000)
DAY_SECONDS = 86400.0

#: What a time may count, in milliseconds, and how long no recorder waits from row to row: that tells which.
UNITS_MS = {"seconds": 1e3, "milliseconds": 1.0, "microseconds": 1e-3, "nanoseconds": 1e-6}
LONGEST_STEP_MS = 4000.0

#: Of columns that have nearly as many times as the finest one, the first of these is the time.
ORDER, FINE = (*UNITS_MS, "timecodes", "frames", ""), 0.8

#: A time falls once where it rises so many times at least; so many rows of a hundred may be left out for it.
RISES_PER_FALL, ROWS_PER_FALL = 4, 50

#: What is larger is no value of a shape, and no time.
LARGEST_VALUE, LARGEST_TIME = 1e6, 1e19


#: names: s, as in the file; values: (f, s) float64, NaN where one is missing; times: (f,) float64 ascending from 0,
#: in frames of the recording; rate_hz: of them, or None: as the scene's; clock: a sentence on where the times are from;
#: notes: sentences on what was left out.
RecordedValues = collections.namedtuple("RecordedValues", "names values times rate_hz clock notes")

#: A column that may be the time: times: (f,), NaN where there is none; rate_hz: as RecordedValues has them.
Clock = collections.namedtuple("Clock", "name times rate_hz words distinct")


def made(records, rate_hz, refuse):
    """The RecordedValues of `records`, {name: cell} each. refuse(reason, row, or None for the whole file) raises."""
    clocks, columns, wordless = [], {}, []
    for name in dict.fromkeys(name for record in records for name in record):
        cells = [record.get(name) for record in records]
        clock = _clock(name, cells, rate_hz, refuse)
        column = None if clock else _numbers(cells, LARGEST_VALUE, f"no number, in column {quoted(name)}", refuse)
        if clock:
            clocks.append(clock)
        elif name and column is None:
            wordless.append(name)
        elif name and folded(name) != COUNT:
            columns[name] = column
    notes = [f"Without numbers, and left out: {wording.quoted(wordless)}"] if wordless else []
    if not columns:
        refuse(". ".join(["it has no names of shapes with numbers", *notes]))
    clocks.append(Clock("", np.arange(len(records), dtype=np.float64), rate_hz, "", 2))
    fewest = FINE * max(clock.distinct for clock in clocks)
    clock = next(each for words in ORDER for each in clocks if each.words == words and each.distinct >= fewest)
    kept = _in_order(clock.times, refuse, notes)
    times, values = _merged(clock.times[kept], np.column_stack(list(columns.values()))[kept], notes)
    rows = f"Each row is a frame, {rate_hz:g} a second" if rate_hz else "No time is there: each row is a frame"
    said = f"Time is {quoted(clock.name)}, in {clock.words}" if clock.words else rows
    return RecordedValues(tuple(columns), values, times - times[0], clock.rate_hz, said, tuple(notes))


def number(cell):
    """The number that a cell is: NaN for a blank one, infinite for what is none."""
    if cell is None or (isinstance(cell, str) and cell.strip().lower() in BLANK):
        return np.nan
    try:
        return np.inf if isinstance(cell, bool) else float(cell.replace(",", ".") if isinstance(cell, str) else cell)
    except (ValueError, OverflowError, TypeError):
        return np.inf


def _numbers(cells, largest, wanted, refuse):
    """(f,) float64, NaN where blank; None if none of them is a number, refused if only some are none."""
    try:
        numbers = np.array(cells if type(cells[0]) in (float, str) else [*map(number, cells)], np.float64)
    except (ValueError, TypeError):  # not all of them are plain numbers
        numbers = np.array([*map(number, cells)])
    wrong = np.abs(numbers) > largest
    if (wrong | np.isnan(numbers)).all():
        return None
    if wrong.any():
        row = int(np.argmax(wrong))
        refuse(f"{quoted(str(cells[row]))} is {wanted}", row)
    return numbers


def _clock(name, cells, rate_hz, refuse):
    """The Clock that a column is by its name and as it rises, but for a few rows; or None."""
    label, code = folded(name), next((cell for cell in cells if isinstance(cell, str) and ":" in cell), "")
    if TIMECODE.fullmatch(code.strip()):
        (times, rate_hz), words = _of_timecodes(cells, rate_hz, refuse), "timecodes"
    else:
        times = _numbers(cells, LARGEST_TIME, "no time", refuse) if CLOCK.search(label) else None
        words = _counts(label, np.median(_rises(times) or [1.0])) if times is not None else ""
        if not words:
            return None
        if words in UNITS_MS:
            times, rate_hz = (times - np.nanmin(times)) * UNITS_MS[words], 1000.0
    is_clock = len(_rises(times)) >= RISES_PER_FALL * len(_rises(-times))
    return Clock(name, times, rate_hz, words, len(np.unique(times))) if is_clock else None


def _counts(label, step):
    """What a time counts, from row to row a step; "" for rows that have numbers without a name, as pandas writes."""
    if "time" not in label and ("frame" in label or step == 1.0):
        return "frames" if label else ""
    return next((words for words, unit in UNITS_MS.items() if step * unit < LONGEST_STEP_MS), "nanoseconds")


def _rises(times):
    return [step for step in np.diff(times[~np.isnan(times)]) if step > 0.0]


def _of_timecodes(cells, rate_hz, refuse):
    """(frames, their rate) of timecodes, NaN where blank."""
    parts = np.full((len(cells), 4), np.nan)
    for row, cell in enumerate(cells):
        found = TIMECODE.fullmatch(str(cell).strip())
        if found:
            parts[row] = [float((part or "0").replace(",", ".")) for part in found.groups()]
        elif not np.isnan(number(cell)):
            refuse(f"{quoted(str(cell))} is no timecode (hours:minutes:seconds:frames)", row)
    highest = math.floor(np.nanmax(parts[:, 3]))
    rate_hz = rate_hz or next((rate for rate in RATES_OF_TIMECODES if rate > highest), highest + 1)
    seconds, there = parts[:, :3] @ [3600.0, 60.0, 1.0], ~np.isnan(parts[:, 0])
    seconds[there] = np.unwrap(seconds[there], period=DAY_SECONDS)  # past midnight
    whole = math.ceil(rate_hz)
    frames = seconds * whole + parts[:, 3]
    if whole in (30, 60) and any(";" in str(cell) for cell in cells):  # drop-frame: minutes but each tenth are shorter
        rate_hz, minutes = whole / 1.001, seconds // 60.0
        frames -= whole // 15 * (minutes - minutes // 10.0)
    return frames, float(rate_hz)


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


SIDES = {"left": "l", "right": "r"}


@functools.lru_cache(4096)
def folded(name):
    """What is left without case and separators, sides as letters: jawOpen, Jaw_Open; EyeBlinkLeft, eyeBlink_L."""
    plain = "".join(letter for letter in name.lower() if letter.isalnum())
    side = next((side for side in SIDES if plain.endswith(side) and plain != side), None)
    return plain if side is None else plain.removesuffix(side) + SIDES[side]


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


def _end(name):
    return folded(re.split(r"[.:|\[]", name.rstrip("]"))[-1])


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
SIMPLER = (str, folded, _end)
