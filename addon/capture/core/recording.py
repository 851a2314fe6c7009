# SPDX-License-Identifier: GPL-3.0-or-later
"""A take, where each marker was in each frame, and what all formats have in common on the way to it."""

import itertools
from dataclasses import dataclass, field

import numpy as np

from ...errors import MotionFileError
from . import units
from .marker_sets import UNLABELLED

#: Meters from the origin beyond which a sample is no measurement but a damaged number.
FARTHEST = 1e4
#: Meters that a subject may have, from a face to several people, that a whole person may, and that most do.
PLAUSIBLE, PERSON, USUAL = (0.1, 10.0), (0.3, 3.0), 1.7
#: Letters of a label that are kept.
LONGEST_LABEL = 120
#: Seconds from the start of a recording to a file: longer ones are times of the day.
LONGEST_START = 3600.0
#: Frames a second that can be.
RATES = (1e-3, 1e6)


@dataclass(frozen=True, eq=False)
class Take:
    """What a motion capture file says of its markers, in metres, right-handed, Z up, whatever the file counts in."""

    name: str  # of the file, without folder and suffix
    rate_hz: float  # frames a second, > 0
    labels: tuple[str, ...]  # unique and never empty, one for each physical marker (of BVH: joints and end sites)
    #: (f, m, 3) float64, read-only; NaN in all three where a sample is missing, never zero for that.
    positions: np.ndarray
    #: What is no marker: kind ("angles", "forces", "virtual points", ...) -> names.
    left_out: dict[str, tuple[str, ...]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()  # what was assumed or mended (unit, up axis, names, ...), in words for the artist
    is_skeleton: bool = False  # of BVH: the labels are joints of a skeleton
    start_s: float = 0.0  # of the first sample, in the recording that the file is a part of

    @property
    def frames(self) -> int:
        return self.positions.shape[0]

    @property
    def measured(self) -> np.ndarray:
        """(f, m) bool: False where a sample is missing."""
        return ~np.isnan(self.positions[..., 0])

    @property
    def missing_share(self) -> float:
        """Share of samples that are missing, 0 to 1."""
        return float(1.0 - self.measured.mean()) if self.positions.size else 0.0


@dataclass
class Recording:
    """What the reader of one format found. Positions are in the file's unit and axes."""

    file: str  # with suffix, for messages; the Take's is without
    labels: list[str]  # as in the file: empty and equal ones are allowed here
    positions: np.ndarray  # (f, m, 3) float64; NaN in any of the three means missing. It may be written to
    rate_hz: float | None = None  # frames a second; None where the file does not say: then they are `usual_rate`
    usual_rate: float = 100.0
    #: For each label None or, of what is no marker, what it is (marker_sets.py); empty: all are markers.
    kinds: list[str | None] = field(default_factory=list)
    unit: str = ""  # what the file calls its unit, "" where it does not say
    up_axis: str | None = None  # one of units.UP_AXES, None where the file does not say
    #: The axis that is up by custom of this format, and words for that.
    usual_up: tuple[str, str] = ("Z", "as most laboratories have it")
    notes: list[str] = field(default_factory=list)
    is_skeleton: bool = False  # the points are joints: they are never missing
    extent: float = 0.0  # how large the subject is at least, in units of the file
    other_scale: float = 1.0  # what another part of the file multiplies the positions with
    start_s: float = 0.0  # as in a Take, or no usable time

    def take(self, up_axis: str | None, unit: float | None) -> Take:
        """In metres, Z up; `up_axis` and `unit` overrule the file. Raises MotionFileError where nothing is left."""
        left_out, rate = {}, self.rate_hz or self.usual_rate
        with np.errstate(all="ignore"):  # damaged numbers overflow: they are looked at afterwards
            missing = ~np.isfinite(self.positions).all(axis=2)
            if not self.is_skeleton:
                # Exact zeros in all three coordinates are how many writers say that a sample is missing. That a marker
                # is measured there is as good as impossible, and costs one sample.
                missing |= ~self.positions.any(axis=2)
            self.positions[missing] = np.nan
            labels, positions = self._markers(left_out)
            up, largest = units.by_names(labels, positions)
            positions *= self._metres(positions, largest, unit)
            told, usual = self.up_axis, self.usual_up[0]
            # An arm may be held in any direction.
            if up is None or (told if largest == np.inf else not told and units.lies(positions, up, usual)):
                up = units.by_floor(positions, told)
            positions = units.turn_up(positions, self._up(up, up_axis))
        self._drop_damaged(positions)
        positions.flags.writeable = False
        if self.rate_hz is None:
            self.notes.append(f"The file names no usable rate: {self.usual_rate:g} frames a second are assumed")
        return Take(
            name=self.file.rpartition(".")[0] or self.file,
            rate_hz=rate,
            labels=self._unique(labels),
            positions=positions,
            left_out={kind: tuple(names) for kind, names in left_out.items()},
            notes=tuple(self.notes),
            is_skeleton=self.is_skeleton,
            start_s=round(self.start_s * rate) / rate if 0.0 < self.start_s < LONGEST_START else 0.0,
        )

    def _markers(self, left_out):
        """(labels, positions) of the markers that are seen; what else there is goes to `left_out`."""
        seen = ~np.isnan(self.positions[..., 0]).all(axis=0)
        if self.is_skeleton and seen.any():
            return self.labels, self.positions
        kinds = np.array(self.kinds or [None] * len(self.labels), object)
        if (kinds[seen] == UNLABELLED).any() and None not in kinds[seen]:
            kinds[kinds == UNLABELLED] = None
            self.notes.append("No marker with a name is ever seen: the unlabelled points are taken as markers")
        kinds[np.equal(kinds, None) & ~seen] = "never seen"
        for label, kind in zip(self.labels, kinds, strict=True):
            if kind is not None:
                left_out.setdefault(kind, []).append(label)
        if None not in kinds:
            counts = ", ".join(f"{len(names)} {kind}" for kind, names in left_out.items())
            raise MotionFileError(f"{self.file}: no marker has a sample ({counts}). Export it with marker trajectories")
        chosen = [number for number, kind in enumerate(kinds) if kind is None]
        return [self.labels[number] for number in chosen], self.positions[:, chosen]

    def _metres(self, positions, largest, chosen):
        """Meters for one unit of the positions, as chosen or as the file says, unless that makes no subject of a size
        that can be. One person is `largest` units at most."""
        if chosen is not None and not (np.isfinite(chosen) and chosen > 0.0):
            raise MotionFileError(f"The unit must be meters for one unit of the file, above 0, and is {chosen}")
        extent = max(self.extent, min(units.median_extent(positions), largest))
        sizes = PLAUSIBLE if largest == np.inf else PERSON
        fits, words = units.guess_unit(extent)
        told = chosen or units.metres_in(self.unit)
        if told is None:
            why = f"Its unit '{self.unit[:LONGEST_LABEL]}' is not known" if self.unit else "The file names no unit"
            self.notes.append(f"{why}: {words}. Choose another unit if the size is wrong")
            return fits

        def is_believable(way):
            return sizes[0] <= extent * way <= sizes[1]

        ways = [way for way in (told, told * self.other_scale) if is_believable(way)]
        ways = ways or [fits if chosen is None and is_believable(fits) else told]
        metres = min(ways, key=lambda way: abs(np.log(extent * way / USUAL))) if extent else told
        by_it = f"By the {'chosen unit' if chosen else 'file'} the subject is {extent * told:.3g} m large"
        if metres != told:
            self.notes.append(f"{by_it}: {extent * metres:.3g} m is assumed. Choose a unit if that is wrong")
        elif extent and not is_believable(told):
            self.notes.append(f"{by_it}. A person would fit {fits:.4g} m for a unit: choose it if this is one")
        return float(metres)

    def _up(self, seen, chosen):
        """The axis that is up: as the artist chose, else as is seen, else as the file says, else by custom."""
        if chosen is not None:
            if chosen not in units.UP_AXES:
                raise MotionFileError(f"'{chosen}' is no axis. Choose which is up among {', '.join(units.UP_AXES)}")
            return chosen
        up, why = (seen, "by where the parts of the body are") if seen else self.usual_up
        if self.up_axis is None:
            self.notes.append(f"The file does not say which axis is up: {up} is assumed, {why}")
        elif seen and seen != self.up_axis:
            self.notes.append(
                f"The file says that {self.up_axis} is up: {up} is taken, {why}. Choose {self.up_axis} as up axis if "
                "the subject lies down or stands on its hands"
            )
        return seen or self.up_axis or up

    def _drop_damaged(self, positions):
        measured = ~np.isnan(positions[..., 0])
        far = measured & ~(np.abs(positions).max(axis=2, initial=0.0) <= FARTHEST)
        count, total = int(far.sum()), int(measured.sum())
        if count == 0:
            return
        what = f"{count} of {total} samples are more than {FARTHEST / 1000.0:g} km from the origin"
        if count > total // 2:
            raise MotionFileError(f"{self.file}: {what}. Choose the unit if it is wrong, or export the file again")
        positions[far] = np.nan
        self.notes.append(f"{what}, and are taken as missing")

    def _unique(self, labels):
        """The labels; none is empty, none is there twice. What was changed is noted."""
        given = [label[:LONGEST_LABEL] for label in labels]
        taken, used, counts, unique = set(given), set(), {}, []
        for number, label in enumerate(given, 1):
            name = wanted = label or f"Point {number}"
            while name in used or (name in taken and name != label):
                name = f"{wanted}_{next(counts.setdefault(wanted, itertools.count(2)))}"
            used.add(name)
            unique.append(name)
        renamed = [name for name, label in zip(unique, given, strict=True) if name != label]
        if renamed:
            self.notes.append(f"{len(renamed)} markers had no name of their own and got a number, as '{renamed[-1]}'")
        return tuple(unique)


def usable_rate(*told: float | None) -> float | None:
    """The first of rates that can be one, in frames a second, or None."""
    return next((float(rate) for rate in told if rate is not None and RATES[0] <= rate <= RATES[1]), None)
