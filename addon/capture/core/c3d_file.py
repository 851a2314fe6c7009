# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads C3D files: all three number formats, whole numbers and floats. Why not a library: docs/decisions/0014.

Header and parameters say most things twice, and files exist where either is wrong (65,535 frames at most in the header,
section starts from before a file was edited): what fits the file's size is taken. Format: "The C3D File Format User
Guide", Motion Lab Systems, 2021.
"""

import itertools
import math
from collections import namedtuple
from dataclasses import dataclass, replace

import numpy as np

from ... import wording
from ...errors import MotionFileError
from . import marker_sets, units
from .recording import Recording, Take, usable_rate
from .text_lines import decoded

BLOCK = 512


@dataclass(frozen=True)
class NumberFormat:
    """How a processor writes numbers. VAX floats are in two swapped little-endian words, with another bias."""

    order: str
    is_vax: bool = False

    def numbers(self, data: bytes, kind: str, start: int, count: int) -> np.ndarray:
        """`kind`: of numpy, i1 to u2 and f4."""
        if kind != "f4" or not self.is_vax:
            return np.frombuffer(data, self.order + kind, count, start)
        words = np.frombuffer(data, "<u2", 2 * count, start).reshape(count, 2)
        with np.errstate(all="ignore"):
            return np.ascontiguousarray(words[:, ::-1]).view("<f4")[:, 0] * np.float32(0.25)


#: By the fourth byte of the parameter section: PC, DEC and SGI.
NUMBER_FORMATS = {84: NumberFormat("<"), 85: NumberFormat("<", is_vax=True), 86: NumberFormat(">")}


class Parameters:
    """Values by group and name, decoded when they are asked for."""

    def __init__(self, data: bytes, start: int, end: int, numbers: NumberFormat):
        """Reads what lies in data[start:end]; a damaged entry ends the section, what came before it stays. Of one that
        is there twice the first counts."""
        self._data = data = data[: min(end, len(data))]
        self._numbers = numbers
        self._entries = {}  # (group number, name) -> (type, dimensions, start of the values)
        self._group_numbers = {}
        at, step = start, 1
        while step and at + 4 <= len(data):
            length, group = self._signed(at), self._signed(at + 1)
            link = at + 2 + abs(length)  # a negative length locks the entry
            if length == 0 or group == 0 or link + 2 > len(data):
                break
            name = data[at + 2 : link].decode("latin-1").strip().upper()
            if group < 0:
                self._group_numbers.setdefault(name, -group)
            elif link + 4 <= len(data):
                dimensions = data[link + 4 : link + 4 + data[link + 3]]
                entry = self._signed(link + 2), dimensions, link + 4 + len(dimensions)
                self._entries.setdefault((group, name), entry)
            step = int(numbers.numbers(data, "u2", link, 1)[0])
            at = link + step

    def _signed(self, at):
        return int.from_bytes(self._data[at : at + 1], "little", signed=True)

    def _find(self, group, name, *kinds):
        """(type, dimensions, start, bytes that are left), or None."""
        kind, dimensions, start = self._entries.get((self._group_numbers.get(group), name), (None, (), 0))
        return (kind, dimensions, start, len(self._data) - start) if kind in kinds else None

    def numbers(self, group: str, name: str, signed: bool = False) -> list[float]:
        """The values, empty where there are none; whole numbers count from 0 unless `signed`."""
        found = self._find(group, name, 1, 2, 4)
        if found is None:
            return []
        size, dimensions, start, left = found
        kind = "f4" if size == 4 else f"{'i' if signed else 'u'}{size}"
        count = max(0, min(math.prod(dimensions), left // size))
        return self._numbers.numbers(self._data, kind, start, count).tolist()

    def number(self, group: str, name: str, signed: bool = False) -> float | None:
        values = self.numbers(group, name, signed)
        return values[0] if values else None

    def strings(self, group: str, name: str) -> list[str]:
        """Without the blanks around them; empty where there are none."""
        _, dimensions, start, left = self._find(group, name, -1) or (-1, (0,), 0, 0)
        width = dimensions[0] if dimensions else 1
        if width == 0:
            return []
        count = max(0, min(math.prod(dimensions[1:]), left // width))
        return [_text(self._data[at : at + width]) for at in range(start, start + count * width, width)]

    def all_strings(self, group: str, name: str) -> list[str]:
        """Those of `name` and of its continuations, name2 and so on, as far as there are some."""
        found, number = self.strings(group, name), 2
        while more := self.strings(group, f"{name}{number}"):
            found += more
            number += 1
        return found


def _text(raw):
    text = decoded(raw.split(b"\0", 1)[0])
    return "".join(letter if letter.isprintable() else " " for letter in text).strip()


MAGIC = 0x50
LONGEST = 65535
AGAIN = "The file is damaged or cut off: export or copy it again"


def read(data: bytes, file: str, up_axis: str | None = None, unit: float | None = None) -> Take:
    """The physical markers of a C3D file of that content; `file` is its name. Raises MotionFileError."""
    numbers, parameters = _sections(data, file)
    words = numbers.numbers(data, "u2", 2, 8).tolist()
    header = _Header(*words[:4], words[7], *(float(numbers.numbers(data, "f4", at, 1)[0]) for at in (12, 20)))
    layout, notes = _find_layout(header, parameters, len(data), file)
    labels = parameters.all_strings("POINT", "LABELS")
    labels = (labels + [""] * layout.points)[: layout.points]
    kind, count = "f4" if layout.is_float else "i2", layout.frames * layout.words
    frames = numbers.numbers(data, kind, layout.start, count).reshape(layout.frames, layout.words)
    frames = frames[:, : 4 * layout.points].reshape(layout.frames, layout.points, 4)
    with np.errstate(all="ignore"):  # damaged floats
        positions = frames[..., :3].astype(np.float64)
        if not layout.is_float:
            positions *= layout.scale
        positions[~(frames[..., 3] >= 0)] = np.nan  # invalid: the fourth word is -1; also where it is NaN
    rate = usable_rate(parameters.number("POINT", "RATE"), header.rate)
    names = (" ".join(parameters.strings("POINT", name)).strip() for name in ("X_SCREEN", "Y_SCREEN"))
    across, up = (name.upper().lstrip("+") for name in names)  # on the screen of the capture system
    is_told = up in units.UP_AXES and across in units.UP_AXES and up[-1] != across[-1]
    return Recording(
        file=file,
        rate_hz=rate,
        labels=labels,
        kinds=marker_sets.kinds(labels, marker_sets.listed_in(parameters)),
        positions=positions,
        unit=_unit(parameters.strings("POINT", "UNITS"), positions),
        up_axis=up if is_told else None,
        usual_up=("Z", "as most C3D files have it"),
        notes=notes,
        other_scale=header.scale / layout.scale if header.scale > 0.0 < layout.scale else 1.0,
        start_s=((_field_number(parameters, "ACTUAL_START_FIELD") or header.first or 1) - 1) / (rate or 1.0),
    ).take(up_axis, unit)


_Header = namedtuple("_Header", "points analog first last data_start scale rate")


@dataclass(frozen=True)
class _Layout:
    """One way to understand a file. A frame is `points` x 4 words, then `analog` words."""

    points: int
    analog: int
    frames: int
    start: int
    scale: float

    @property
    def is_float(self):
        return self.scale < 0.0

    @property
    def words(self):
        return 4 * self.points + self.analog

    def left_over(self, size):
        return size - self.start - self.frames * self.words * (4 if self.is_float else 2)


def _sections(data, file):
    """(number format, parameters). Raises MotionFileError where this is no C3D file."""
    if len(data) < 2 * BLOCK or data[1] != MAGIC:
        raise MotionFileError(
            f"{file}: this is no C3D file (it has {len(data)} bytes and does not begin as one). Choose the file that "
            "the capture system exported"
        )
    start = (data[0] - 1) * BLOCK
    if not 0 < start <= len(data) - 4:
        raise MotionFileError(f"{file}: its parameters should be in block {data[0]}, where there is nothing. {AGAIN}")
    blocks, processor = data[start + 2], data[start + 3]
    if processor not in NUMBER_FORMATS:
        raise MotionFileError(
            f"{file}: its number format {processor} is none of 84 (PC), 85 (DEC) and 86 (SGI). {AGAIN}"
        )
    numbers = NUMBER_FORMATS[processor]
    return numbers, Parameters(data, start + 4, start + (blocks or 255) * BLOCK, numbers)


def _find_layout(header, parameters, size, file):
    """(the layout that fits a file of `size` bytes, notes where the file is shorter or longer than it says).

    Raises MotionFileError where nothing fits. Frames never go beyond the file's end.
    """
    candidates = list(_candidates(header, parameters))
    if not candidates:
        segments = parameters.all_strings("ROTATION", "LABELS")
        only = f"{header.points} of them, frames {header.first} to {header.last}, scale {header.scale:g}"
        if segments:
            only = f"only rotations of {len(segments)} segments, {wording.quoted(segments)}"
        raise MotionFileError(f"{file}: it has no points ({only}). Export the take with its marker trajectories")
    fitting = [layout for layout in candidates if layout.left_over(size) >= 0]
    exact = [layout for layout in fitting if layout.left_over(size) < BLOCK]
    layout = (exact or fitting or candidates)[0]
    present = max(0, size - layout.start) // (layout.words * (4 if layout.is_float else 2))
    if present == 0:
        raise MotionFileError(
            f"{file}: it should have {layout.frames} frames of {layout.points} points from byte {layout.start} on, and "
            f"has {size} bytes. {AGAIN}"
        )
    if present < layout.frames:
        note = f"The file is cut off: {present} of its {layout.frames} frames are there"
        return replace(layout, frames=present), [note]
    if layout.frames == LONGEST < present:
        note = f"The file counts frames only up to {LONGEST} and has more: all {present} are read"
        return replace(layout, frames=present), [note]
    return layout, []


def _candidates(header, parameters):
    """All ways to understand the file, the likeliest first: parameters count before the header."""
    channels, rate = (parameters.number("ANALOG", name) or 0 for name in ("USED", "RATE"))
    points_rate = parameters.number("POINT", "RATE")
    ratio = rate / points_rate if points_rate else 0.0
    ends = [_field_number(parameters, f"ACTUAL_{end}_FIELD") for end in ("START", "END")]
    counts = (
        None if None in ends else ends[1] - ends[0] + 1,
        parameters.number("POINT", "LONG_FRAMES"),
        header.last - header.first + 1,
        parameters.number("POINT", "FRAMES"),
    )
    for points, analog, frames, block, scale in itertools.product(
        _distinct(parameters.number("POINT", "USED"), header.points),
        _distinct(header.analog, channels * round(ratio) if 0.0 < ratio < 1e6 else None),
        _distinct(*counts),
        _distinct(header.data_start, parameters.number("POINT", "DATA_START")),
        (parameters.number("POINT", "SCALE", signed=True), header.scale),
    ):
        is_scale = scale is not None and math.isfinite(scale) and 1e-12 < abs(scale) < 1e12
        if points > 0 and frames > 0 and block > 1 and is_scale:
            yield _Layout(points, analog, frames, (block - 1) * BLOCK, float(scale))


def _unit(names, positions):
    """The unit of (f, m, 3) positions by one name for all or a name for each; what has another unit is brought to the
    first that is known."""
    metres = [units.metres_in(name) for name in names]
    first = next((one for one in metres if one), None)
    for number, one in enumerate(metres[: positions.shape[1]]):
        if one and one != first:
            positions[:, number] *= one / first
    return names[metres.index(first)] if first else " ".join(names)


def _distinct(*values):
    return list(dict.fromkeys(int(value) for value in values if value is not None and math.isfinite(value)))


def _field_number(parameters, name):
    """A frame number of TRIAL: two words, the lower first, or one float or whole number; or None."""
    values = parameters.numbers("TRIAL", name)
    if not values or not all(math.isfinite(value) for value in values[:2]):
        return None
    return int(values[0]) + (65536 * values[1] if len(values) > 1 and isinstance(values[1], int) else 0)
