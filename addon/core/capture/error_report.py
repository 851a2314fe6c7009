# SPDX-License-Identifier: GPL-3.0-or-later
"""How far filled gaps are from the truth, found by hiding what was measured."""

from dataclasses import dataclass

import numpy as np

from . import checks
from .gaps import fill_gaps

#: Gaps that are hidden in each marker at most; more tell little more.
MOST_GAPS = 8


@dataclass(frozen=True, eq=False)
class LeaveOneOut:
    """Metres for each of m markers; NaN where nothing could be hidden or filled."""

    #: (m,) root mean square and (m,) largest distance of filled samples from the hidden ones.
    rms: np.ndarray
    largest: np.ndarray
    #: (m,) share of the hidden samples that could be filled.
    filled: np.ndarray
    gap: int

    def words(self, labels, limit=3):
        """For the artist: the mean, and the markers whose gaps should be looked at."""
        if np.isnan(self.rms).all():
            return "Nothing could be hidden: no marker is seen long enough at a time."
        overall = np.sqrt(np.nanmean(self.rms**2))
        worst = np.argsort(np.where(np.isnan(self.rms), -1.0, self.rms))[::-1][:limit]
        told = ", ".join(f"{labels[k]} {1000.0 * self.rms[k]:.0f} mm" for k in worst if not np.isnan(self.rms[k]))
        return f"Gaps of {self.gap} samples are filled to {1000.0 * overall:.1f} mm (rms); least surely: {told}."


def leave_one_out(positions, gap=20, longest_spline=10, longest_rigid=200):
    """`LeaveOneOut` of a take: each marker alone is hidden in up to MOST_GAPS gaps, filled, and compared.

    positions  (f, m, 3), NaN where missing; gap  samples that are hidden at a time; the others as of `fill_gaps()`.
    Raises InvalidMotionError for wrong shapes and gaps below 1.
    """
    positions = checks.motion(positions)
    if gap < 1:
        raise checks.InvalidMotionError(f"Gaps of {gap} samples can't be hidden; 1 is the shortest.")
    count = positions.shape[1]
    rms, largest, share = (np.full(count, np.nan) for _ in range(3))
    known = ~np.isnan(positions[..., 0])
    for marker in range(count):
        hidden = _hidden(known[:, marker], gap)
        if not hidden.any():
            continue
        holed = positions.copy()
        holed[hidden, marker] = np.nan
        filled, _ = fill_gaps(holed, longest_spline, longest_rigid)
        off = np.linalg.norm(filled[hidden, marker] - positions[hidden, marker], axis=1)
        off = off[~np.isnan(off)]
        share[marker] = len(off) / hidden.sum()
        if len(off):
            rms[marker], largest[marker] = np.sqrt((off**2).mean()), off.max()
    return LeaveOneOut(rms, largest, share, int(gap))


def _hidden(known, gap):
    """(f,) bool: gaps spread over the frames, with as many good samples between, nothing at the ends."""
    result = np.zeros(len(known), bool)
    starts = np.arange(gap, len(known) - 2 * gap + 1, 2 * gap)
    if not len(starts):
        return result
    starts = starts[np.unique(np.linspace(0, len(starts) - 1, MOST_GAPS).astype(int))]
    for start in starts:
        if known[start - 1 : start + gap + 1].all():
            result[start : start + gap] = True
    return result
