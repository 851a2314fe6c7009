# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/scene/core: moves of controls, and whether points hold a mesh; run without Blender."""

import itertools

import numpy as np
import pytest

from addon.scene.core import motion, point_sets
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
