# SPDX-License-Identifier: GPL-3.0-or-later
"""One recording: where each marker was in each frame."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True, eq=False)
class Take:
    """What a motion capture file says of its markers, in metres, right-handed, Z up, whatever the file counts in."""

    #: Of the file, without folder and suffix.
    name: str
    #: Frames a second, > 0.
    rate_hz: float
    #: Unique and never empty, one for each physical marker (of BVH: joints and end sites).
    labels: tuple[str, ...]
    #: (f, m, 3) float64, read-only; NaN in all three where a sample is missing, never zero for that.
    positions: np.ndarray
    #: What is no marker: kind ("angles", "forces", "virtual points", ...) -> names.
    left_out: dict[str, tuple[str, ...]] = field(default_factory=dict)
    #: What was assumed or mended (unit, up axis, names, ...), in words for the artist.
    notes: tuple[str, ...] = ()
    #: Of BVH: the labels are joints of a skeleton.
    is_skeleton: bool = False

    @property
    def frames(self) -> int:
        return self.positions.shape[0]

    @property
    def seconds(self) -> float:
        """From the first sample to the last."""
        return max(self.frames - 1, 0) / self.rate_hz

    @property
    def measured(self) -> np.ndarray:
        """(f, m) bool: False where a sample is missing."""
        return ~np.isnan(self.positions[..., 0])

    @property
    def missing_share(self) -> float:
        """Share of samples that are missing, 0 to 1."""
        return float(1.0 - self.measured.mean()) if self.positions.size else 0.0
