# SPDX-License-Identifier: GPL-3.0-or-later
"""From what a file holds, in its own units and axes, to a Take: what all formats have in common."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...errors import MotionFileError
from . import units
from .take import Take

#: Metres from the origin beyond which a sample is no measurement but a damaged number.
FARTHEST = 1e4
#: Metres that people and the room they move in have; beyond that the unit is in doubt.
PLAUSIBLE = (0.02, 50.0)
#: Metres that a person may have, in any pose: beyond that a unit that was chosen is in doubt.
PLAUSIBLE_PERSON = (0.4, 4.0)
#: Letters of a label that are kept.
LONGEST_LABEL = 120


@dataclass
class Recording:
    """What the reader of one format found. Positions are in the file's unit and axes."""

    #: With suffix, for messages; the Take's is without.
    file: str
    rate_hz: float
    first_frame: int
    #: As in the file: empty and equal ones are allowed here.
    labels: list[str]
    #: (f, m, 3) float64; NaN in any of the three means missing.
    positions: np.ndarray
    #: Metres for one unit, None where the file does not say.
    unit: float | None = None
    #: One of units.UP_AXES, None where the file does not say.
    up_axis: str | None = None
    #: The axis that is up by custom of this format or maker, and words for that.
    usual_up: tuple[str, str] = ("Z", "as most laboratories have it")
    left_out: dict[str, tuple[str, ...]] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    parents: tuple[int, ...] = ()
    #: Exact zeros in all three coordinates are how many writers of this format say that a sample is missing, with or
    #: without a residual of -1. That a marker is measured there is as good as impossible, and costs one sample.
    zero_is_missing: bool = True
    #: A marker without any sample is left out (not where it has a place in a hierarchy).
    drops_never_seen: bool = True

    def take(self, up_axis: str | None, unit: float | None) -> Take:
        """In metres, Z up; `up_axis` and `unit` overrule the file. Raises MotionFileError where nothing is left."""
        with np.errstate(all="ignore"):  # damaged numbers overflow: they are looked at afterwards
            positions = self._in_metres(self._cleaned(self.positions), unit)
            up = self._up(positions, up_axis)
            positions = units.turn_up(positions, up)
        self._drop_damaged(positions)
        labels, positions = self._seen(self._unique_labels(), positions)
        positions.flags.writeable = False
        return Take(
            name=self.file.rpartition(".")[0] or self.file,
            rate_hz=self.rate_hz,
            first_frame=self.first_frame,
            labels=labels,
            positions=positions,
            left_out=dict(self.left_out),
            notes=tuple(self.notes),
            parents=self.parents,
        )

    def _cleaned(self, positions):
        """NaN in all three where a sample is missing; the array is this recording's own and is written to."""
        missing = ~np.isfinite(positions).all(axis=2)
        if self.zero_is_missing:
            missing |= ~positions.any(axis=2)
        positions[missing] = np.nan
        return positions

    def _in_metres(self, positions, chosen):
        if chosen is not None:
            if not (np.isfinite(chosen) and chosen > 0.0):
                raise MotionFileError(f"The unit must be meters for one unit of the file, above 0, and is {chosen}")
            metres = float(chosen)
            extent = metres * self.spread(positions)
            if extent > 0.0 and not PLAUSIBLE_PERSON[0] <= extent <= PLAUSIBLE_PERSON[1]:
                fits, _ = units.guess_unit(self.spread(positions))
                self.notes.append(
                    f"In the chosen unit the subject is {units.length(extent)} large, which no person is. A person "
                    f"would fit {fits:.4g} m for a unit of the file; choose another unit if this is one"
                )
        elif self.unit is not None:
            metres = self.unit
            extent = metres * self.spread(positions)
            if extent > 0.0 and not PLAUSIBLE[0] <= extent <= PLAUSIBLE[1]:
                self.notes.append(f"By the file's unit the markers are {extent:.3g} m apart: choose another unit")
        else:
            metres, words = units.guess_unit(self.spread(positions))
            self.notes.append(f"The file names no unit: {words}. Choose another unit if the size is wrong")
        positions *= metres
        return positions

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

    def _unique_labels(self):
        """No label is empty, none is there twice; what was changed is noted."""
        given = [label[:LONGEST_LABEL] for label in self.labels]
        taken, used, following = set(given), set(), {}  # following: name -> the number to try next: many may be equal
        nameless, renamed, labels = 0, [], []
        for number, label in enumerate(given, 1):
            unique = label or f"Point {number}"
            if unique in used or (not label and unique in taken):
                count = following.get(unique, 2)
                while f"{unique}_{count}" in taken:
                    count += 1
                following[unique], unique = count + 1, f"{unique}_{count}"
                taken.add(unique)
            nameless += not label
            renamed += [unique] if label and unique != label else []
            used.add(unique)
            labels.append(unique)
        if nameless:
            self.notes.append(f"{nameless} markers without a name are called after their number, as 'Point 1'")
        if renamed:
            self.notes.append(f"{len(renamed)} markers had the name of another and got a number, as '{renamed[-1]}'")
        return tuple(labels)

    def _seen(self, labels, positions):
        """Without the markers that have no sample at all."""
        seen = ~np.isnan(positions[..., 0]).all(axis=0)
        if not seen.any() or positions.shape[0] == 0:
            raise MotionFileError(
                f"{self.file}: none of its {len(labels)} markers has a sample in any of {positions.shape[0]} frames. "
                "Export the take again, with its trajectories"
            )
        if self.drops_never_seen and not seen.all():
            self.left_out["never seen"] = tuple(label for label, keep in zip(labels, seen, strict=True) if not keep)
            labels = tuple(label for label, keep in zip(labels, seen, strict=True) if keep)
            positions = positions[:, seen]
        return labels, positions
