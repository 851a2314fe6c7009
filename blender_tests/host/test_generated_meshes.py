# SPDX-License-Identifier: GPL-3.0-or-later
"""What holds for every mesh: generated ones of all scales, far from the origin."""

import numpy as np
import pytest

meanvalue = pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")

from blender_tests.support import stress  # noqa: E402

SCALES = [10.0**power for power in range(-6, 7, 3)]
#: Diagonals from the origin.
FAR = [0.0, 1e5]


def bar(seed):
    """(vertices, faces) of diagonal 1, with its vertices a little off their places."""
    points, faces = stress.bar(300)
    points = np.asarray(points, np.float64)
    points /= np.linalg.norm(np.ptp(points, axis=0))
    return points + np.random.default_rng(seed).normal(scale=0.002, size=points.shape), np.asarray(faces, np.int32)


def ends(points):
    """Anchors at both ends, their handles, and targets that turn the right one by 40 degrees and move it."""
    along = points[:, 0]
    left = along < along.min() + 0.1 * np.ptp(along)
    right = along > along.max() - 0.1 * np.ptp(along)
    anchors = np.flatnonzero(left | right).astype(np.int32)
    pieces = right[anchors].astype(np.int32)
    sine, cosine = np.sin(0.7), np.cos(0.7)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    targets = points[anchors].copy()
    targets[pieces == 1] = points.mean(axis=0) + (targets[pieces == 1] - points.mean(axis=0)) @ turn.T + [0, 0, 0.1]
    return anchors, pieces, targets


def solved(points, faces, anchors, pieces, targets):
    deformer = meanvalue.Deformer(points, faces, anchors, handles=pieces, threads=1)
    solution = deformer.solve(targets)
    np.testing.assert_array_equal(solution.vertices[anchors], targets)
    assert np.isfinite(solution.vertices).all()
    return np.array(solution.vertices)


@pytest.mark.parametrize("seed", range(3))
def test_the_shape_is_the_same_at_every_scale_and_place(seed):
    rng = np.random.default_rng(seed)
    points, faces = bar(seed)
    anchors, pieces, targets = ends(points)
    expected = solved(points, faces, anchors, pieces, targets)
    assert np.abs(expected - points).max() > 0.1
    direction = rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    for scale in SCALES:
        for far in FAR:
            away = far * direction
            found = solved(scale * (points + away), faces, anchors, pieces, scale * (targets + away)) / scale - away
            # What rounding takes from the coordinates far away, and what a solve leaves within its tolerance.
            assert np.abs(found - expected).max() < 1e-3, (scale, far)
