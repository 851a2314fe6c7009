# SPDX-License-Identifier: GPL-3.0-or-later
"""Units of length and upright axes of motion capture files: what they are called, and plausible guesses."""

import numpy as np

#: Frames that are enough to guess by.
FEW = 200

UP_AXES = ("X", "Y", "Z", "-X", "-Y", "-Z")

#: Meters for one unit, by what files call it (lower case).
METRES = {
    **dict.fromkeys(("m", "meter", "meters", "metre", "metres"), 1.0),
    **dict.fromkeys(("dm", "decimeter", "decimeters", "decimetre", "decimetres"), 0.1),
    **dict.fromkeys(("cm", "centimeter", "centimeters", "centimetre", "centimetres"), 0.01),
    **dict.fromkeys(("mm", "millimeter", "millimeters", "millimetre", "millimetres"), 0.001),
    **dict.fromkeys(("in", "inch", "inches"), 0.0254),
    **dict.fromkeys(("ft", "foot", "feet"), 0.3048),
}

#: (extent of a person from, to, in units; metres for one; what it is called). The CMU motions as BVH count in 1/0.45
#: inches.
_SIZES_OF_PEOPLE = (
    (0.5, 2.5, 1.0, "meters"),
    (5.0, 25.0, 0.1, "decimeters"),
    (25.0, 40.0, 0.0254 / 0.45, "1/0.45 inches, as in the CMU motions,"),
    (40.0, 95.0, 0.0254, "inches"),
    (95.0, 400.0, 0.01, "centimeters"),
    (400.0, 4000.0, 0.001, "millimeters"),
)

#: Rows that turn each axis up without mirroring.
_TURNS = {
    "Z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "Y": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
    "X": ((0, 1, 0), (0, 0, 1), (1, 0, 0)),
    "-Z": ((1, 0, 0), (0, -1, 0), (0, 0, -1)),
    "-Y": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "-X": ((0, 0, 1), (0, 1, 0), (-1, 0, 0)),
}


def metres_in(name: str) -> float | None:
    """Meters for one unit of that name, None for one that is not known."""
    return METRES.get(name.strip().strip(".[]()").lower())


def turn_up(positions: np.ndarray, up_axis: str) -> np.ndarray:
    """(..., 3) `positions` turned so that their `up_axis` is Z, exactly and right-handed; may be the same array."""
    return positions if up_axis == "Z" else positions @ np.array(_TURNS[up_axis], np.float64).T


def few(positions: np.ndarray) -> np.ndarray:
    """At most FEW of the frames of (f, m, 3), evenly spread, that have any marker."""
    some = positions[:: max(1, -(-len(positions) // FEW))]
    return some[(~np.isnan(some[..., 0])).any(axis=1)]


def median_extent(positions: np.ndarray) -> float:
    """The largest side of the box around all markers, as it is in half of the frames; 0 without markers."""
    some = few(positions)
    return float(np.median((np.nanmax(some, axis=1) - np.nanmin(some, axis=1)).max(axis=1))) if some.size else 0.0


def guess_unit(extent: float) -> tuple[float, str]:
    """Meters for one unit if something of `extent` units is a person, and words for that."""
    for smallest, largest, metres, name in _SIZES_OF_PEOPLE:
        if smallest <= extent < largest:
            return metres, f"{name} are assumed, which makes the subject {extent * metres:.2f} m large"
    return 0.01, f"centimeters are assumed (the subject is {extent:.4g} units large, which fits a person in no unit)"


def length(metres: float) -> str:
    """Meters as people say it: "1.4 cm", "1.75 m"."""
    return f"{100.0 * metres:.2g} cm" if metres < 0.995 else f"{metres:.3g} m"
