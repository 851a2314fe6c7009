# SPDX-License-Identifier: GPL-3.0-or-later
"""How well the frames of a bake were solved."""

from dataclasses import dataclass

import numpy as np

from ... import wording
from .bake_times import named

#: Of each row in a report: how far the farthest handle is from its target, the energy for a diagonal of 1 or None,
#: iterations, whether it converged, "" or why it could not be solved, so that it has the shape of the row before.
REPORTED = ("distances", "energies", "iterations", "converged", "errors")

#: So many of the worst frames are listed.
WORST_COUNT = 5


def with_frames(former, frames):
    """The frames of an earlier report with `frames` (as of BakeReport.content()) in the place of their own.

    What of `former` is no such list, or is no frame, is left out: the file is the artist's to write to.
    """
    new = {each["frame"] for each in frames}
    kept = [each for each in former if _is_frame(each)] if isinstance(former, list) else []
    return sorted([*(each for each in kept if each["frame"] not in new), *frames], key=lambda each: each["frame"])


def _is_frame(value):
    return (
        isinstance(value, dict)
        and _is_number(value.get("frame"))
        and all(value.get(name) is None or _is_number(value[name]) for name in ("energy", "distance"))
    )


def _is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e300


@dataclass(frozen=True, eq=False)
class BakeReport:
    """Of f frames.

    energies: for a rest shape of diagonal 1, NaN where it failed; distances: of the farthest anchor that counts from
    its target, in the object's own units; errors: texts, "" for none.
    """

    times: np.ndarray
    energies: np.ndarray
    distances: np.ndarray
    iterations: np.ndarray
    converged: np.ndarray
    errors: tuple

    @classmethod
    def of(cls, times, columns):
        """columns: {name: f values}, as a ChunkStore keeps them."""
        return cls(
            np.asarray(times, np.float64),
            np.array([np.nan if value is None else value for value in columns["energies"]], np.float64),
            np.asarray(columns["distances"], np.float64),
            np.asarray(columns["iterations"], np.int64),
            np.asarray(columns["converged"], bool),
            tuple(columns["errors"]),
        )

    def worst(self):
        """[(frame, energy)] of the largest energies, the worst first."""
        known = np.where(np.isfinite(self.energies), self.energies, -np.inf)
        order = np.argsort(-known, kind="stable")[:WORST_COUNT]
        return [(named(self.times[row]), float(known[row])) for row in order if np.isfinite(known[row])]

    def text(self):
        worst = self.worst()
        text = wording.counted(len(self.times), "sample")
        if worst:
            text += f", the highest energy is {worst[0][1]:.3g} at frame {worst[0][0]}{self._compared(worst[0][1])}"
        if len(self.distances) and self.distances.max() > 0.0:
            row = int(self.distances.argmax())
            text += f", a handle is {self.distances[row]:.3g} from its target at frame {named(self.times[row])}"
        return text

    def _compared(self, energy):
        """What an energy, which has no scale that anybody knows, means."""
        usual = float(np.nanmedian(self.energies))
        times = f"{energy / usual:.1f} times the median; " if usual > 0.0 else ""
        return f" ({times}it is 0 for the rest shape: look where it is many times the median)"

    def notes(self):
        """Sentences on frames to look at."""
        failed = [row for row, error in enumerate(self.errors) if error]
        if failed:
            yield (
                f"{wording.counted(len(failed), 'frame')} could not be solved ({self._frames(failed)}): "
                f"{self.errors[failed[0]]}"
            )
        failed_rows = set(failed)
        early = [row for row in np.flatnonzero(~self.converged) if row not in failed_rows]
        if early:
            worst = wording.listed(f"{frame} (energy {energy:.3g})" for frame, energy in self.worst())
            yield (
                f"{wording.counted(len(early), 'frame')} stopped before they had converged ({self._frames(early)}). "
                f"Look at the worst ones: {worst}"
            )

    def content(self):
        """For a JSON file."""
        return {
            "worst": [{"frame": frame, "energy": energy} for frame, energy in self.worst()],
            "frames": [
                {
                    "frame": float(time),
                    "energy": float(energy) if np.isfinite(energy) else None,
                    "distance": float(distance),
                    "iterations": int(iterations),
                    "converged": bool(converged),
                    **({"error": error} if error else {}),
                }
                for time, energy, distance, iterations, converged, error in zip(
                    self.times, self.energies, self.distances, self.iterations, self.converged, self.errors, strict=True
                )
            ],
        }

    def _frames(self, rows, most=8):
        names = [named(self.times[row]) for row in rows[:most]]
        return ", ".join(names) + (", ..." if len(rows) > most else "")
