# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/baking/core: times of samples, and which frames are kept as keys."""

import numpy as np
import pytest

from addon.baking.core import bake_times
from addon.errors import SceneError
from addon.solver.job import result_of


def test_times():
    assert bake_times.sample_times(1, 4).tolist() == [1, 2, 3, 4]
    assert bake_times.sample_times(1, 2, samples=4).tolist() == [1, 1.25, 1.5, 1.75, 2]
    assert bake_times.sample_times(3, 3).tolist() == [3]
    with pytest.raises(SceneError, match="ends before it begins"):
        bake_times.sample_times(4, 1)


def test_straight_motion_needs_two_keys_and_each_corner_one():
    times = np.arange(31.0)
    path = np.interp(times, [0, 10, 30], [0.0, 5.0, -5.0])
    rows = np.zeros((31, 4, 3), np.float32)
    rows[:, 2, 1] = path
    assert result_of(bake_times.reduced(rows, times, 1e-4)) == [0, 10, 30]
    assert result_of(bake_times.reduced(rows[:11], times, 1e-4)) == [0, 10]
    assert result_of(bake_times.reduced(rows[:1], times, 1e-4)) == [0]


@pytest.mark.parametrize("tolerance", [0.0, 0.001, 0.05, 1.0])
def test_every_row_is_within_the_tolerance(tolerance):
    times = np.sort(np.random.default_rng(2).uniform(0, 40, 60))
    phase = np.linspace(0, 6, 5)[None, :, None]
    rows = np.sin(0.3 * times[:, None, None] + phase * [1, 2, 3]).astype(np.float32)
    kept = result_of(bake_times.reduced(rows, times, tolerance))
    assert kept[0] == 0
    assert kept[-1] == 59
    assert kept == sorted(set(kept))
    blends = [np.interp(times, times[kept], path) for path in rows[kept].reshape(len(kept), -1).T]
    off = np.linalg.norm(np.stack(blends, axis=1).reshape(rows.shape) - rows, axis=2)
    assert off.max() <= tolerance + 1e-6
    if tolerance >= 0.05:
        assert len(kept) < 40
    if tolerance == 0.0:
        assert len(kept) == 60
