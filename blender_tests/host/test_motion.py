# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/scene/core: moves of controls, and whether points hold a mesh; run without Blender."""

import itertools

import numpy as np
import pytest

from addon.scene.core import motion, point_sets
from addon.scene.core.motion import fit_rotations
from native.benchmarks.rigid import rotation_about


def similarity(points, scale, offset):
    return (scale * points @ rotation_about((1.0, 2.0, 3.0), 63.0).T + offset).astype(np.float32)


TRIANGLE = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.3, 0.2, 0.0)])


LINE = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.3, 0.0, 0.0), (0.9, 0.0, 0.0)])


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("points, spans", [(TRIANGLE, True), (LINE, False), (LINE[:2], False), (LINE[:0], False)])
def test_plane_or_line_wherever_and_however_large(scale, points, spans):
    for order in itertools.permutations(range(len(points))):
        assert point_sets.span_a_plane(similarity(points[list(order)], scale, 2.0 * scale)) == spans


def a_move():
    """A turn by 50 degrees about (1, 2, 2), and a step."""
    move = np.eye(4)
    move[:3, :3] = rotation_about((1.0, 2.0, 2.0), 50.0)
    move[:3, 3] = (3.0, -1.0, 0.5)
    return move


def test_a_control_that_only_differs_by_noise_moves_nothing():
    relation = a_move()
    noisy = (relation.astype(np.float32) * np.float32(1.0 + 1e-7)).astype(np.float64)
    points = np.random.default_rng(1).normal(size=(5, 3)).astype(np.float32)
    moved = motion.apply(motion.between(relation, noisy), points)
    assert np.array_equal(moved, points.astype(np.float64))


def test_the_move_between_two_relations_takes_points_along():
    rest = a_move()
    points = np.random.default_rng(2).normal(size=(5, 3))
    move = motion.between(rest, a_move() @ rest)
    assert np.allclose(move, a_move(), atol=1e-12)
    assert np.allclose(motion.apply(move, points), points @ a_move()[:3, :3].T + a_move()[:3, 3])


def test_a_rigid_move_is_fitted_exactly():
    points = np.random.default_rng(3).normal(size=(6, 3))
    assert np.allclose(motion.fitted(points, motion.apply(a_move(), points)), a_move(), atol=1e-12)
    flat = points * (1.0, 1.0, 0.0)
    assert np.allclose(motion.fitted(flat, motion.apply(a_move(), flat)), a_move(), atol=1e-12)


@pytest.mark.parametrize("count", [1, 3])
def test_what_points_leave_open_is_not_turned(count):
    line = np.outer(np.arange(count), (1.0, 0.0, 0.0))
    move = motion.fitted(line, line + np.array((0.0, 2.0, 0.0)))
    assert np.allclose(move[:3, :3], np.eye(3))
    assert np.allclose(move[:3, 3], (0.0, 2.0, 0.0))


# -- rotations fitted to many sets of points at once -------------------------------------------------------------------


def random_rotations(rng, count):
    quaternions = rng.standard_normal((count, 4))
    w, x, y, z = (quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.array(rows).transpose(2, 0, 1)


def test_a_rotation_is_found_with_missing_points_and_weights():
    rng = np.random.default_rng(1)
    turns = random_rotations(rng, 20)
    points = rng.standard_normal((6, 3))
    moved = np.einsum("fij,kj->fki", turns, points) + rng.standard_normal((20, 1, 3))
    assert np.abs(fit_rotations(points, moved) - turns).max() < 1e-8
    moved[3, :2] = np.nan
    assert np.abs(fit_rotations(points, moved) - turns).max() < 1e-8
    moved[:, 5] += 10.0
    assert np.abs(fit_rotations(points, moved, [1, 1, 1, 1, 1, 0]) - turns).max() < 1e-8


def test_what_points_leave_open_is_as_the_prior_has_it():
    rng = np.random.default_rng(2)
    prior = random_rotations(rng, 10)
    line = np.linspace(0, 1, 4)[:, None] * [[0.0, 0.0, 1.0]]
    moved = np.einsum("fij,kj->fki", prior, line)
    assert np.abs(fit_rotations(line, moved, prior=prior) - prior).max() < 1e-6
    assert np.abs(fit_rotations(line[:1], moved[:, :1], prior=prior) - prior).max() < 1e-6
    nothing = np.full((10, 4, 3), np.nan)
    assert np.abs(fit_rotations(line, nothing, prior=prior) - prior).max() < 1e-6
    assert np.abs(fit_rotations(line, nothing) - np.eye(3)).max() < 1e-12
    # Without a prior a line is turned the least way.
    quarter = fit_rotations(line, line @ np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]]))
    assert np.abs(quarter @ [1.0, 0.0, 0.0] - [1.0, 0.0, 0.0]).max() < 1e-6
