# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/core/capture: swapped and jumping markers, put into a generated walk; without Blender."""

import numpy as np
import pytest

from addon.capture.core.jumps import find_jumps
from blender_tests.support import walking_figure


def swapped(positions, one, other, begin, end=None):
    result = positions.copy()
    result[begin:end, [one, other]] = positions[begin:end, [other, one]]
    return result


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 0.001, 0.002])
@pytest.mark.parametrize("gaps", [0.0, 0.1, 0.2])
def test_clean_walks_have_nothing_to_find(noise, gaps):
    for seed in range(4):
        walk = walking_figure.take(300, seed=seed, gaps=gaps, noise=noise, longest_gap=60)
        assert find_jumps(walk.positions, 100.0, walk.labels) == []


def test_fast_motion_is_no_jump():
    """Three times as fast, hands whirling at ten metres a second, and a drop that ends hard on the ground."""
    walk = walking_figure.take(900)
    assert find_jumps(walk.clean[::3], 100.0) == []
    body = walk.clean[:200].copy()
    angle = 2.0 * np.pi * 3.0 * np.arange(200) / 100.0
    for marker in [walk.labels.index(label) for label in ("LHandOut", "LWristIn", "LWristOut")]:
        body[:, marker] += 0.55 * np.stack([np.cos(angle), np.sin(angle), np.zeros(200)], axis=1)
    assert np.linalg.norm(np.diff(body, axis=0), axis=2).max() > 0.09
    assert find_jumps(body, 100.0) == []
    falls = walk.clean[:200].copy()
    height = np.maximum(0.0, 0.6 - 0.5 * 9.81 * (np.arange(200) / 100.0) ** 2)
    falls[..., 2] += height[:, None]
    assert find_jumps(falls, 100.0) == []


def test_swaps_are_found_with_both_markers_and_the_sample():
    walk = walking_figure.take(300, seed=1, noise=0.001)
    labels = walk.labels
    for one, other, begin in (("LKneeOut", "RKneeOut", 100), ("HeadTop", "LToeTip", 33), ("RWristIn", "RHandOut", 250)):
        path = swapped(walk.positions, labels.index(one), labels.index(other), begin)
        (found,) = find_jumps(path, 100.0, labels)
        assert (found.kind, {labels[found.marker], labels[found.other]}, found.sample) == ("swap", {one, other}, begin)


@pytest.mark.slow
def test_most_random_swaps_are_found_and_little_else():
    rng = np.random.default_rng(0)
    found_without_gap, found_after_gap, others = [], [], 0
    for seed in range(60):
        walk = walking_figure.take(300, seed=seed, noise=0.001, gaps=0.05 if seed % 2 else 0.0)
        one, other = rng.choice(41, 2, replace=False)
        begin, gap = int(rng.integers(20, 280)), int(rng.integers(0, 12)) if seed % 3 == 0 else 0
        path = swapped(walk.positions, one, other, begin)
        path[begin - gap : begin, [one, other]] = np.nan
        findings = find_jumps(path, 100.0)
        right = [f for f in findings if f.kind == "swap" and {f.marker, f.other} == {one, other}]
        (found_after_gap if gap else found_without_gap).append(bool(right))
        others += len(findings) - len(right)
    assert np.mean(found_without_gap) >= 0.95
    assert np.mean(found_after_gap) >= 0.7
    assert others <= 4  # halves of swaps that were not recognised as such


def test_a_swap_that_is_undone_is_found_twice():
    walk = walking_figure.take(300)
    findings = find_jumps(swapped(walk.clean, 12, 30, 100, 150), 100.0)
    assert [(f.kind, f.sample) for f in findings] == [("swap", 100), ("swap", 150)]


def test_jumps_away_and_back():
    walk = walking_figure.take(300, noise=0.0005)
    path = walk.positions.copy()
    path[120:123, 7] += [0.1, 0.0, 0.05]
    path[200:, 20] += [0.0, 0.06, 0.0]
    away, back, jump = find_jumps(path, 100.0, walk.labels)
    assert [(found.kind, found.marker, found.sample) for found in (away, back)] == [("jump", 7, 120), ("jump", 7, 123)]
    assert (jump.kind, jump.marker, jump.sample, jump.other) == ("jump", 20, 200, None)


def test_takes_with_hardly_anything_in_them():
    nothing = np.full((5, 3, 3), np.nan)
    assert find_jumps(nothing, 100.0) == []
    assert find_jumps(np.zeros((1, 2, 3)), 100.0) == []


def test_joints_of_skeletons_are_neither_swapped_nor_renamed():
    walk = walking_figure.take(200)
    path = walk.clean.copy()
    path[100:, 3] += [0.4, 0.0, 0.0]
    (marker,), (joint,) = (find_jumps(path, 100.0, walk.labels, are_joints) for are_joints in (False, True))
    assert (joint.sample, joint.marker) == (marker.sample, marker.marker) == (100, 3)
    path = swapped(walk.clean, 7, 20, 100)
    assert {finding.kind for finding in find_jumps(path, 100.0)} == {"swap"}
    assert all("swap" not in finding.words for finding in find_jumps(path, 100.0, are_joints=True))
