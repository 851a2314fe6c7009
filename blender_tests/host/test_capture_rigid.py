# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/core/capture: rotations fitted to many sets of points at once; without Blender."""

import numpy as np

from addon.scene.core.motion import fit_rotations


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
