# SPDX-License-Identifier: GPL-3.0-or-later
"""What holds for every mesh: generated ones of all scales, far from the origin, cut and welded."""

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


def cut(points, faces, rng):
    """Opened along a line: where the two sides meet, each has vertices of its own."""
    middle = points[faces].mean(axis=1)[:, 0]
    beyond = middle > np.quantile(middle, rng.uniform(0.3, 0.7))
    shared = np.intersect1d(faces[beyond], faces[~beyond])
    numbers = np.arange(len(points))
    numbers[shared] = len(points) + np.arange(len(shared))
    faces = faces.copy()
    faces[beyond] = numbers[faces[beyond]]
    return np.concatenate([points, points[shared]]), faces


def welded(points, faces, rng):
    """Two vertices made one here and there, and what collapses by that left out: no manifold any more."""
    numbers = np.arange(len(points))
    for a, b in rng.choice(len(points), (4, 2), replace=False):
        numbers[b] = a
    faces = numbers[faces]
    whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return points, faces[whole]


def as_it_is(points, faces, _rng):
    return points, faces


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


@pytest.mark.parametrize("damage", [as_it_is, cut, welded])
@pytest.mark.parametrize("seed", range(3))
def test_the_shape_is_the_same_at_every_scale_and_place(damage, seed):
    rng = np.random.default_rng(seed)
    points, faces = damage(*bar(seed), rng)
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
