# SPDX-License-Identifier: GPL-3.0-or-later
"""Where in a C3D file the samples are: header and parameters, checked against each other and the file's size.

Header and parameters say most things twice, and files exist where either is wrong (65,535 frames at most in the header,
section starts from before a file was edited): what fits the file is taken.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

from ...errors import MotionFileError
from .c3d_parameters import BLOCK, NUMBER_FORMATS, NumberFormat, Parameters

MAGIC = 0x50
LONGEST = 65535


@dataclass(frozen=True)
class Layout:
    """One way to understand a file. A frame is `points` x 4 words, then `analog` words."""

    points: int
    analog: int
    frames: int
    start: int
    scale: float
    numbers: NumberFormat

    @property
    def is_float(self) -> bool:
        return self.scale < 0.0

    @property
    def word(self) -> int:
        return 4 if self.is_float else 2

    @property
    def frame_bytes(self) -> int:
        return (4 * self.points + self.analog) * self.word

    def left_over(self, size: int) -> int:
        return size - self.start - self.frames * self.frame_bytes

    def frames_that_fit(self, size: int) -> int:
        return max(0, size - self.start) // self.frame_bytes


@dataclass(frozen=True)
class Header:
    points: int
    analog: int
    first: int
    last: int
    scale: float
    data_start: int
    rate: float


def open_sections(data: bytes, file: str) -> tuple[Header, Parameters, NumberFormat]:
    """Raises MotionFileError where this is no C3D file."""
    if len(data) < 2 * BLOCK or data[1] != MAGIC:
        raise MotionFileError(
            f"{file}: this is no C3D file (it has {len(data)} bytes and does not begin as one). Choose the file that "
            "the capture system exported"
        )
    start = (data[0] - 1) * BLOCK
    if not 0 < start <= len(data) - 4:
        raise MotionFileError(f"{file}: its parameters should be in block {data[0]}, where there is nothing. {AGAIN}")
    blocks, processor = data[start + 2], data[start + 3]
    numbers = NUMBER_FORMATS.get(processor)
    if numbers is None:
        raise MotionFileError(
            f"{file}: its number format {processor} is none of 84 (PC), 85 (DEC) and 86 (SGI). {AGAIN}"
        )
    parameters = Parameters(data, start + 4, start + (blocks or 255) * BLOCK, numbers)
    return _header(data, numbers), parameters, numbers


AGAIN = "The file is damaged or cut off: export or copy it again"


def _header(data, numbers):
    words = [int(value) for value in numbers.uint16(data, 2, 9)]
    return Header(
        points=words[0],
        analog=words[1],
        first=words[2],
        last=words[3],
        scale=float(numbers.float32(data, 12, 1)[0]),
        data_start=words[7],
        rate=float(numbers.float32(data, 20, 1)[0]),
    )


def frame_rate(header: Header, parameters: Parameters) -> float | None:
    for rate in (parameters.number("POINT", "RATE"), header.rate):
        if rate is not None and math.isfinite(rate) and 1e-3 <= rate <= 1e6:
            return float(rate)
    return None


def field_number(parameters: Parameters, name: str) -> int | None:
    """A frame number of TRIAL: two words, the lower first, or one float or whole number."""
    values = parameters.numbers("TRIAL", name)
    if not values or not all(math.isfinite(value) for value in values[:2]):
        return None
    return int(values[0]) + (65536 * int(values[1]) if len(values) > 1 and isinstance(values[1], int) else 0)


def first_frame(header: Header, parameters: Parameters) -> int:
    first = field_number(parameters, "ACTUAL_START_FIELD")
    return header.first if first is None else first


def find_layout(
    header: Header, parameters: Parameters, numbers: NumberFormat, size: int, file: str
) -> tuple[Layout, str]:
    """The layout that fits a file of `size` bytes, and a note where the file is shorter or longer than it says.

    Raises MotionFileError where nothing fits. Frames never go beyond the file's end.
    """
    candidates = list(_candidates(header, parameters, numbers))
    if not candidates:
        raise MotionFileError(
            f"{file}: it has no points ({header.points} of them, frames {header.first} to {header.last}, scale "
            f"{header.scale:g}). Export the take with its marker trajectories"
        )
    fitting = [layout for layout in candidates if layout.left_over(size) >= 0]
    exact = [layout for layout in fitting if layout.left_over(size) < BLOCK]
    if exact or fitting:
        layout = (exact or fitting)[0]
        if layout.frames == LONGEST and layout.frames_that_fit(size) > LONGEST:
            layout = Layout(**{**vars(layout), "frames": layout.frames_that_fit(size)})
            return layout, f"The file counts frames only up to {LONGEST} and has more: all {layout.frames} are read"
        return layout, ""
    told = candidates[0]
    present = told.frames_that_fit(size)
    if present == 0:
        raise MotionFileError(
            f"{file}: it should have {told.frames} frames of {told.points} points from byte {told.start} on, and has "
            f"{size} bytes. {AGAIN}"
        )
    layout = Layout(**{**vars(told), "frames": present})
    return layout, f"The file is cut off: {present} of its {told.frames} frames are there"


def _candidates(header, parameters, numbers):
    """All ways to understand the file, the likeliest first: parameters count before the header."""
    points = _distinct(parameters.number("POINT", "USED"), header.points)
    analog = _distinct(header.analog, _analog_words(parameters))
    frames = _distinct(*_frame_counts(header, parameters))
    blocks = _distinct(header.data_start, parameters.number("POINT", "DATA_START"))
    scales = [scale for scale in (parameters.number("POINT", "SCALE", signed=True), header.scale) if _is_scale(scale)]
    for point, words, frame, block, scale in itertools.product(points, analog, frames, blocks, scales):
        if point > 0 and frame > 0 and block > 1:
            yield Layout(point, words, frame, (block - 1) * BLOCK, float(scale), numbers)


def _is_scale(scale):
    return scale is not None and math.isfinite(scale) and 1e-12 < abs(scale) < 1e12


def _distinct(*values):
    return list(dict.fromkeys(int(value) for value in values if value is not None and math.isfinite(value)))


def _analog_words(parameters):
    """Analog words in a frame: channels times samples for each frame of points."""
    channels, rate = parameters.number("ANALOG", "USED"), parameters.number("ANALOG", "RATE")
    points_rate = parameters.number("POINT", "RATE")
    if not channels or not rate or not points_rate:
        return None
    ratio = rate / points_rate
    return channels * round(ratio) if math.isfinite(ratio) and 0.0 < ratio < 1e6 else None


def _frame_counts(header, parameters):
    first, last = field_number(parameters, "ACTUAL_START_FIELD"), field_number(parameters, "ACTUAL_END_FIELD")
    if first is not None and last is not None:
        yield last - first + 1
    yield parameters.number("POINT", "LONG_FRAMES")
    yield header.last - header.first + 1
    yield parameters.number("POINT", "FRAMES")
