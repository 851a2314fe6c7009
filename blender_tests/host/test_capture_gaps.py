# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/core/capture: gaps and filter, on a generated walk; without Blender."""

import numpy as np
import pytest

from addon.capture.core import gaps
from addon.errors import InvalidMotionError
from blender_tests.support import walking_figure


@pytest.fixture(scope="module")
def walk():
    return walking_figure.take(400, seed=3)


def with_gap(positions, marker, begin, end):
    result = positions.copy()
    result[begin:end, marker] = np.nan
    return result


def largest_step(positions):
    return np.nanmax(np.linalg.norm(np.diff(positions, axis=0), axis=2))


# -- gaps -------------------------------------------------------------------------------------------------------------


def test_measured_samples_keep_their_bits(walk):
    holed = walking_figure.drop_samples(walk.clean, 0.1, np.random.default_rng(0))
    before = holed.copy()
    filled, is_measured = gaps.fill_gaps(holed), ~np.isnan(holed)
    assert np.array_equal(holed, before, equal_nan=True)
    assert np.array_equal(filled[is_measured], walk.clean[is_measured])


@pytest.mark.parametrize("label", ["LHandOut", "RToeTip", "HeadTop", "RKneeOut"])
def test_short_gaps_are_smooth_and_near_the_truth(walk, label):
    marker = walk.labels.index(label)
    for begin in range(50, 300, 23):
        filled = gaps.fill_gaps(with_gap(walk.clean, marker, begin, begin + 8), longest_rigid=0)
        assert np.linalg.norm(filled - walk.clean, axis=2).max() < 0.012
        # C1: the step into the gap is that before it, but for what the motion itself bends in two samples.
        steps = np.diff(filled[begin - 3 : begin + 11, marker], axis=0)
        true_steps = np.diff(walk.clean[begin - 3 : begin + 11, marker], axis=0)
        assert np.abs(np.diff(steps, axis=0)).max() < np.abs(np.diff(true_steps, axis=0)).max() + 0.004


def test_longer_gaps_move_with_a_rigid_body():
    rng = np.random.default_rng(1)
    body = rng.standard_normal((5, 3))
    turns = walking_figure.turn_z(np.linspace(0, 3, 200)) @ walking_figure.turn_x(np.linspace(0, 2, 200))
    path = np.einsum("fij,mj->fmi", turns, body) + np.linspace(0, 1, 200)[:, None, None] * [1.0, 2.0, 0.5]
    filled = gaps.fill_gaps(with_gap(path, 2, 60, 160), longest_spline=0)
    assert np.abs(filled - path).max() < 1e-9
    at_the_start = gaps.fill_gaps(with_gap(path, 2, 0, 100))
    assert np.abs(at_the_start - path).max() < 1e-9


def test_what_differs_at_the_far_end_is_faded_in(walk):
    """Soft tissue: the marker is elsewhere on its body when it is seen again, and nothing jumps."""
    marker = walk.labels.index("LThigh")
    path = walk.clean.copy()
    path[150:, marker] += [0.02, 0.0, 0.01]
    holed = with_gap(path, marker, 100, 150)
    filled = gaps.fill_gaps(holed, longest_spline=0)
    steps = np.linalg.norm(np.diff(filled[95:155, marker], axis=0), axis=1)
    true_steps = np.linalg.norm(np.diff(walk.clean[95:155, marker], axis=0), axis=1)
    assert np.abs(steps - true_steps).max() < 0.008


def test_too_long_gaps_and_lonely_markers_stay_missing(walk):
    assert np.isnan(gaps.fill_gaps(with_gap(walk.clean, 3, 50, 350), longest_rigid=200)[50:350, 3]).all()
    two = with_gap(walk.clean[:, :2], 0, 100, 150)
    assert np.isnan(gaps.fill_gaps(two)[100:150, 0]).all()
    never = with_gap(walk.clean, 5, 0, 400)
    assert np.isnan(gaps.fill_gaps(never, 1000, 1000)[:, 5]).all()


def test_nothing_is_made_up_beyond_the_ends_of_a_take(walk):
    alone = walk.clean[:, :1]
    assert np.isnan(gaps.fill_gaps(with_gap(alone, 0, 397, 400))[397:, 0]).all()
    assert np.isnan(gaps.fill_gaps(with_gap(alone, 0, 0, 8))[:8, 0]).all()


def test_many_gaps_in_noise_give_continuous_motion():
    walk = walking_figure.take(600, seed=8, gaps=0.166, noise=0.0005, longest_gap=60)
    assert np.isnan(walk.positions[..., 0]).any(axis=0).all()  # no marker is complete
    filled, missing = gaps.fill_gaps(walk.positions), np.isnan(walk.positions[..., 0])
    is_short = missing & ~np.isnan(gaps.fill_gaps(walk.positions, longest_rigid=0)[..., 0])
    error = np.linalg.norm(filled - walk.clean, axis=2)
    assert not np.isnan(filled).any(axis=2).mean() > 0.01
    assert np.sqrt(np.nanmean(error[is_short] ** 2)) < 0.004
    assert np.sqrt(np.nanmean(error[missing & ~is_short] ** 2)) < 0.02
    assert largest_step(filled) < 1.15 * largest_step(walk.clean)


# -- filter -----------------------------------------------------------------------------------------------------------


def wave(hertz, rate=100.0, frames=1000):
    return np.sin(2.0 * np.pi * hertz * np.arange(frames) / rate)[:, None, None] * np.ones((1, 2, 3))


def test_half_the_power_is_left_at_the_cut_off_and_nothing_is_delayed():
    for cutoff in (3.0, 6.0, 20.0):
        before = wave(cutoff)
        after = gaps.low_pass(before, 100.0, cutoff)
        middle = slice(300, 700)
        assert np.sqrt((after[middle] ** 2).mean() / (before[middle] ** 2).mean()) == pytest.approx(2**-0.5, rel=5e-3)
        assert np.abs(after[middle] - 2**-0.5 * before[middle]).max() < 0.01
    slow = wave(0.5)
    assert np.abs(gaps.low_pass(slow, 100.0, 10.0) - slow).max() < 2e-3
    assert np.abs(gaps.low_pass(wave(30.0), 100.0, 6.0)[100:900]).max() < 0.01


def test_straight_paths_and_rest_are_kept_to_their_ends():
    line = np.linspace(0.0, 4.0, 200)[:, None, None] * [1.0, -2.0, 0.3] + [5.0, 0.0, 1.0]
    assert np.abs(gaps.low_pass(line, 100.0, 6.0) - line).max() < 5e-3
    rest = np.full((50, 3, 3), 7.25)
    assert np.abs(gaps.low_pass(rest, 100.0, 6.0) - rest).max() < 1e-12


def test_gaps_separate_runs_and_stay(walk):
    holed = with_gap(with_gap(walk.clean, 4, 100, 120), 4, 121, 130)
    after = gaps.low_pass(holed, 100.0, 8.0)
    assert np.array_equal(np.isnan(after), np.isnan(holed))
    assert np.array_equal(after[120, 4], holed[120, 4])  # a single sample has nothing to be smoothed by
    alone = gaps.low_pass(holed[:100], 100.0, 8.0)
    assert np.abs(after[:100, 4] - alone[:, 4]).max() < 1e-12
    other = gaps.low_pass(walk.clean, 100.0, 8.0)
    assert np.abs(after[:, 5] - other[:, 5]).max() < 1e-12


@pytest.mark.parametrize(("rate", "cutoff"), [(100.0, 50.0), (10.0, 6.0)])
def test_impossible_cut_offs_are_refused(rate, cutoff):
    with pytest.raises(InvalidMotionError, match="Hz"):
        gaps.low_pass(np.zeros((10, 1, 3)), rate, cutoff)
