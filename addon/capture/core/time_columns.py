# SPDX-License-Identifier: GPL-3.0-or-later
"""Which column of a file is the time, and what it counts: names and numbers tell."""

import collections
import functools
import math
import re

import numpy as np

from .text_lines import quoted

#: Names, as folded() has them, of what may be a time.
CLOCK = re.compile(r"time|stamp|clock|elapsed|frame|ms$|sec(ond)?s?$|^t?s?$")
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

#: A time falls once where it rises so many times at least. What is larger is no time.
RISES_PER_FALL, LARGEST_TIME = 4, 1e19

#: A column that may be the time: times: (f,), NaN for none; rate_hz: of them, or None; words: what it counts.
Clock = collections.namedtuple("Clock", "name times rate_hz words distinct")


def the_time(clocks, rows, rate_hz):
    """The Clock of `clocks` that counts finest, else the numbers of the rows."""
    clocks = [*clocks, Clock("", np.arange(rows, dtype=np.float64), rate_hz, "", 2)]
    fewest = FINE * max(clock.distinct for clock in clocks)
    return next(each for words in ORDER for each in clocks if each.words == words and each.distinct >= fewest)


def number(cell):
    """The number that a cell is: NaN for a blank one, infinite for what is none."""
    if cell is None or (isinstance(cell, str) and cell.strip().lower() in BLANK):
        return np.nan
    try:
        return np.inf if isinstance(cell, bool) else float(cell.replace(",", ".") if isinstance(cell, str) else cell)
    except (ValueError, OverflowError, TypeError):
        return np.inf


def numbers(cells, largest, wanted, refuse):
    """(f,) float64, NaN where blank; None if none of them is a number, refused if only some are none."""
    try:
        found = np.array(cells if type(cells[0]) in (float, str) else [*map(number, cells)], np.float64)
    except (ValueError, TypeError, OverflowError):  # not all of them are plain numbers
        found = np.array([*map(number, cells)])
    wrong = np.abs(found) > largest
    if (wrong | np.isnan(found)).all():
        return None
    if wrong.any():
        row = int(np.argmax(wrong))
        refuse(f"{quoted(str(cells[row]))} is {wanted}", row)
    return found


def clock_of(name, cells, rate_hz, refuse):
    """The Clock that a column is by its name and as it rises, but for a few rows; or None."""
    label, code = folded(name), next((cell for cell in cells if isinstance(cell, str) and ":" in cell), "")
    if TIMECODE.fullmatch(code.strip()):
        (times, rate_hz), words = _of_timecodes(cells, rate_hz, refuse), "timecodes"
    else:
        times = numbers(cells, LARGEST_TIME, "no time", refuse) if CLOCK.search(label) else None
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


SIDES = {"left": "l", "right": "r"}


@functools.lru_cache(4096)
def folded(name):
    """What is left without case and separators, sides as letters: jawOpen, Jaw_Open; EyeBlinkLeft, eyeBlink_L."""
    plain = "".join(letter for letter in name.lower() if letter.isalnum())
    side = next((side for side in SIDES if plain.endswith(side) and plain != side), None)
    return plain if side is None else plain.removesuffix(side) + SIDES[side]
