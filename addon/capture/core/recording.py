# SPDX-License-Identifier: GPL-3.0-or-later
"""A take, where each marker was in each frame, and what all formats have in common on the way to it."""

import itertools
from dataclasses import dataclass, field

import numpy as np

from ...errors import MotionFileError
from . import units

#: Meters from the origin beyond which a sample is no measurement but a damaged number.
FARTHEST = 1e4
#: Meters that a subject may have, from a face to several people: beyond that its unit is in doubt.
PLAUSIBLE = (0.1, 10.0)
#: Letters of a label that are kept.
LONGEST_LABEL = 120
#: Frames a second that can be.
RATES = (1e-3, 1e6)


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


@dataclass
class Recording:
    """What the reader of one format found. Positions are in the file's unit and axes."""

    #: With suffix, for messages; the Take's is without.
    file: str
    #: As in the file: empty and equal ones are allowed here.
    labels: list[str]
    #: (f, m, 3) float64; NaN in any of the three means missing. It may be written to.
    positions: np.ndarray
    #: Frames a second; None where the file does not say: then they are `usual_rate`.
    rate_hz: float | None = None
    usual_rate: float = 100.0
    #: For each label None or, of what is no marker, what it is (model_outputs.py); empty: all are markers.
    kinds: list[str | None] = field(default_factory=list)
    #: What the file calls its unit, "" where it does not say.
    unit: str = ""
    #: One of units.UP_AXES, None where the file does not say.
    up_axis: str | None = None
    #: The axis that is up by custom of this format or maker, and words for that.
    usual_up: tuple[str, str] = ("Z", "as most laboratories have it")
    notes: list[str] = field(default_factory=list)
    #: The points are joints: they are never missing.
    is_skeleton: bool = False

    def take(self, up_axis: str | None, unit: float | None) -> Take:
        """In metres, Z up; `up_axis` and `unit` overrule the file. Raises MotionFileError where nothing is left."""
        left_out = {}
        labels, positions = self._markers(left_out)
        with np.errstate(all="ignore"):  # damaged numbers overflow: they are looked at afterwards
            self._clean(positions)
            positions *= self._metres(positions, unit)
            positions = units.turn_up(positions, self._up(positions, up_axis))
        self._drop_damaged(positions)
        labels, positions = self._seen(self._unique(labels), positions, left_out)
        positions.flags.writeable = False
        if self.rate_hz is None:
            self.notes.append(f"The file names no usable rate: {self.usual_rate:g} frames a second are assumed")
        return Take(
            name=self.file.rpartition(".")[0] or self.file,
            rate_hz=self.rate_hz or self.usual_rate,
            labels=labels,
            positions=positions,
            left_out={kind: tuple(names) for kind, names in left_out.items()},
            notes=tuple(self.notes),
            is_skeleton=self.is_skeleton,
        )

    def _markers(self, left_out):
        """(labels, positions) without what is no marker, which goes to `left_out`."""
        if not any(self.kinds):
            return self.labels, self.positions
        for label, kind in zip(self.labels, self.kinds, strict=True):
            if kind is not None:
                left_out.setdefault(kind, []).append(label)
        chosen = [number for number, kind in enumerate(self.kinds) if kind is None]
        if not chosen:
            counts = ", ".join(f"{len(names)} {kind}" for kind, names in left_out.items())
            raise MotionFileError(
                f"{self.file}: it has no marker, only what a model computed ({counts}). Export the take with its "
                "marker trajectories"
            )
        return [self.labels[number] for number in chosen], self.positions[:, chosen]

    def _clean(self, positions):
        """NaN in all three where a sample is missing."""
        missing = ~np.isfinite(positions).all(axis=2)
        if not self.is_skeleton:
            # Exact zeros in all three coordinates are how many writers say that a sample is missing. That a marker is
            # measured there is as good as impossible, and costs one sample.
            missing |= ~positions.any(axis=2)
        positions[missing] = np.nan

    def _metres(self, positions, chosen):
        """Meters for one unit of the file."""
        if chosen is not None and not (np.isfinite(chosen) and chosen > 0.0):
            raise MotionFileError(f"The unit must be meters for one unit of the file, above 0, and is {chosen}")
        told = units.metres_in(self.unit)
        if self.unit and told is None:
            self.notes.append(f"The file's unit '{self.unit[:LONGEST_LABEL]}' is not known")
        spread = self.spread(positions)
        fits, words = units.guess_unit(spread)
        metres = told if chosen is None else chosen
        if metres is None:
            self.notes.append(f"The file names no unit: {words}. Choose another unit if the size is wrong")
            return fits
        extent = metres * spread
        if extent > 0.0 and not PLAUSIBLE[0] <= extent <= PLAUSIBLE[1]:
            whose = "the file's unit" if chosen is None else "the chosen unit"
            self.notes.append(
                f"By {whose} the subject is {units.length(extent)} large. A person would fit {fits:.4g} m for a unit "
                "of the file; choose another unit if this is one"
            )
        return float(metres)

    def spread(self, positions):
        """The largest extent of the subject in units of the file, about its height; 0 where there is nothing."""
        return units.median_extent(positions)

    def _up(self, positions, chosen):
        """`positions` in metres, in the axes of the file."""
        if chosen is not None:
            if chosen not in units.UP_AXES:
                raise MotionFileError(f"'{chosen}' is no axis. Choose which is up among {', '.join(units.UP_AXES)}")
            return chosen
        seen, why = self.seen_up(positions)
        if self.up_axis is not None:
            if seen is not None and seen != self.up_axis:
                self.notes.append(
                    f"The file says that {self.up_axis} is up, but {seen} is the axis {why}. Choose {seen} as up axis "
                    "if the subject lies down"
                )
            return self.up_axis
        if seen is None:
            seen, why = self.usual_up
        self.notes.append(f"The file does not say which axis is up: {seen} is assumed, {why}")
        return seen

    def seen_up(self, positions):
        """(axis, why) by the positions, (f, m, 3) in metres; (None, "") where they leave it open."""
        seen = units.likely_up(positions)
        return seen, "along which the markers stand on a floor" if seen else ""

    def _drop_damaged(self, positions):
        measured = ~np.isnan(positions[..., 0])
        far = measured & ~(np.abs(positions).max(axis=2, initial=0.0) <= FARTHEST)
        count, total = int(far.sum()), int(measured.sum())
        if count == 0:
            return
        if count > total // 2:
            raise MotionFileError(
                f"{self.file}: {count} of {total} samples are more than {FARTHEST / 1000.0:g} km from the origin. The "
                "file is damaged, or its unit is wrong: export it again, or choose the unit"
            )
        positions[far] = np.nan
        self.notes.append(f"{count} samples more than {FARTHEST / 1000.0:g} km from the origin are taken as missing")

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
        nameless = given.count("")
        renamed = [name for name, label in zip(unique, given, strict=True) if label and name != label]
        if nameless:
            self.notes.append(f"{nameless} markers without a name are called after their number, as 'Point 1'")
        if renamed:
            self.notes.append(f"{len(renamed)} markers had the name of another and got a number, as '{renamed[-1]}'")
        return tuple(unique)

    def _seen(self, labels, positions, left_out):
        """Without the markers that have no sample at all, which go to `left_out`."""
        seen = ~np.isnan(positions[..., 0]).all(axis=0)
        if not seen.any() or positions.shape[0] == 0:
            raise MotionFileError(
                f"{self.file}: none of its {len(labels)} markers has a sample in any of {positions.shape[0]} frames. "
                "Export the take again, with its trajectories"
            )
        if not self.is_skeleton and not seen.all():
            left_out["never seen"] = [label for label, keep in zip(labels, seen, strict=True) if not keep]
            labels = tuple(label for label, keep in zip(labels, seen, strict=True) if keep)
            positions = positions[:, seen]
        return labels, positions


def usable_rate(*told: float | None) -> float | None:
    """The first of rates that can be one, in frames a second, or None."""
    return next((float(rate) for rate in told if rate is not None and RATES[0] <= rate <= RATES[1]), None)
