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
    number = value.get("frame") if isinstance(value, dict) else None
    return isinstance(number, (int, float)) and not isinstance(number, bool) and abs(number) < 1e300


@dataclass(frozen=True, eq=False)
class BakeReport:
    """Of f frames: their times, and for each of REPORTED f values."""

    times: np.ndarray
    columns: dict

    @property
    def _energies(self):
        """f float64, NaN where a frame failed."""
        return np.array([np.nan if value is None else value for value in self.columns["energies"]], np.float64)

    def worst(self):
        """[(frame, energy)] of the largest energies, the worst first."""
        energies = self._energies
        order = np.argsort(-np.nan_to_num(energies, nan=-np.inf), kind="stable")[:WORST_COUNT]
        return [(named(self.times[row]), float(energies[row])) for row in order if np.isfinite(energies[row])]

    def notes(self):
        """Sentences on frames to look at."""
        errors, converged = self.columns["errors"], self.columns["converged"]
        failed = [row for row, error in enumerate(errors) if error]
        if failed:
            frames = wording.counted(len(failed), "frame")
            yield f"{frames} could not be solved ({self._frames(failed)}): {errors[failed[0]]}"
        early = [row for row, is_converged in enumerate(converged) if not is_converged and not errors[row]]
        if early:
            frames = wording.counted(len(early), "frame")
            yield f"{frames} stopped before they had converged ({self._frames(early)}). Look at them"

    def content(self):
        """For a JSON file."""
        rows = zip(self.times, *(self.columns[name] for name in REPORTED), strict=True)
        return {
            "worst": [{"frame": frame, "energy": energy} for frame, energy in self.worst()],
            "frames": [
                {
                    "frame": float(time),
                    "energy": energy,
                    "distance": distance,
                    "iterations": iterations,
                    "converged": converged,
                    **({"error": error} if error else {}),
                }
                for time, distance, energy, iterations, converged, error in rows
            ],
        }

    def _frames(self, rows, most=8):
        names = [named(self.times[row]) for row in rows[:most]]
        return ", ".join(names) + (", ..." if len(rows) > most else "")
