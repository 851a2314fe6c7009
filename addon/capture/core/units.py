# SPDX-License-Identifier: GPL-3.0-or-later
"""Units of length and upright axes of motion capture files: what they are called, and plausible guesses.
Which axis is up is told by where the parts of the body are while they move."""

import re

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


#: What names have in them: the height over that of the standing body. What fits first counts.
_HEIGHTS = tuple((re.compile(words), height) for words, height in (
    (r"(?<!h)ank|mal(l|$)|(?<!w)heel|hee$|foot|toe|mt\d|metat|calc|cal$", 0.03), ("shank|shin|tib|fib", 0.2),
    ("pelvi|hip|asi|psi|sacr|waist|up_?leg|upper_?leg", 0.55), ("thigh|thi$|fem", 0.42), ("kne|leg|calf", 0.28),
    ("wri|wr[ab]$|hand|styl", 0.48), ("elb|epicond", 0.63), ("head|skull|nose|ear$|[fb]hd", 0.94), ("neck|c7$", 0.85),
    ("should|sho(?!e)|acr|clav|collar|scap", 0.81), ("chest|stern|strn|thora|^tv?10$", 0.74), ("spine|back|bak$", 0.67),
))  # fmt: skip
#: The share of markers whose heights must be known; the cosine of the angle to an axis within which a body is along it;
#: heights that who crawls travels farther along the body than across; share of the height that all but a limb spans;
#: heights, as its parts tell it, that a body may be large, with its arms spread or as it bends.
KNOWN, ALONG, CRAWLS, WHOLE, LARGEST = 0.2, 0.7, 0.6, 0.5, 1.6
#: Meters that nothing of who lies is above the floor, on a bed.
LYING = 1.0


def by_names(labels, positions):
    """(axis, largest): one of UP_AXES, along which what is higher on a body by its name is higher, mostly,
    None without such names or where that is not clear; how large one person is at most, whatever else is captured,
    infinite if the parts are no more than an arm, a shank or a trunk.

    labels  m names; positions  (f, m, 3), NaN for what is missing.
    """
    names = [label[-100:].rsplit(":", 1)[-1].casefold() for label in labels]
    heights = np.array([next((height for words, height in _HEIGHTS if words.search(name)), np.nan) for name in names])
    levels = np.unique(heights[~np.isnan(heights)])
    if np.isnan(heights).mean() > 1.0 - KNOWN:
        return None, np.inf
    parts = [few(positions)[:, heights == level] for level in levels]
    middles = np.stack([np.nansum(part, axis=1) / (~np.isnan(part)).sum(axis=1) for part in parts])
    is_often_seen = np.isfinite(middles).all(axis=2).mean(axis=1) > 0.5
    levels, middles = levels[is_often_seen], middles[is_often_seen]
    middles = middles[:, np.isfinite(middles).all(axis=(0, 2))]
    if len(levels) < 2 or middles.shape[1] == 0:
        return None, np.inf
    ways = np.tensordot(levels - levels.mean(), middles, 1) / (levels @ (levels - levels.mean()))
    lengths = np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-12)
    mean = np.median(ways / lengths, axis=0)
    travel = np.ptp(np.quantile(middles.mean(axis=0), [0.05, 0.95], axis=0), axis=0)
    axis = int(np.argmax(np.abs(mean)))
    crawls = travel[axis] > np.delete(travel, axis).max() + CRAWLS * np.median(lengths)
    up = ("-" if mean[axis] < 0.0 else "") + "XYZ"[axis] if np.abs(mean[axis]) > ALONG and not crawls else None
    return up, LARGEST * np.quantile(lengths, 0.95) if np.ptp(levels) > WHOLE else np.inf


def by_floor(positions, told):
    """The one of "Y" and "Z", or of what is told and its opposite, along which the markers, (f, m, 3) in metres, stand
    on a floor at 0: feet stay near it in nearly every frame and heads far above it. None if it is not just one."""
    found = [up for up in ((told[-1], "-" + told[-1]) if told else "YZ") if _stands(_levels(positions, up))]
    return found[0] if len(found) == 1 else None


def lies(positions, up, usual):
    """Whether the markers, (f, m, 3) in metres, are of one who lies, along an axis `up`, low above a floor at 0 of the
    axis that is up by custom: all of them, throughout, and along `up` is no floor."""
    lows, highs = _levels(positions, usual)
    return lows[0] > -0.03 and highs[1] < LYING and not _stands(_levels(positions, up))


def _levels(positions, up):
    """(lows, highs): what the lowest and the highest marker of a frame are above usually, and below."""
    heights = turn_up(few(positions), up)[..., 2]
    return [np.quantile(ends(heights, axis=1), [0.05, 0.95]) for ends in (np.nanmin, np.nanmax)]


def _stands(levels):
    lows, highs = levels
    return lows[0] > -0.15 and lows[1] < 0.35 and highs[0] > 0.7 and highs[1] < 2.8
