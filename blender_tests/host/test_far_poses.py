# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/posing/core/far_poses.py: which poses differ most."""

import numpy as np

from addon.posing.core import far_poses


def bent(angle, turn=0.0):
    """(20, 3): a line along x, bent in its middle, and turned as a whole."""
    x = np.linspace(-1.0, 1.0, 20)
    points = np.stack([np.where(x < 0.0, x, x * np.cos(angle)), np.where(x < 0.0, 0.0, x * np.sin(angle)), 0.0 * x], 1)
    rotation = np.array([[np.cos(turn), -np.sin(turn), 0.0], [np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]])
    return points @ rotation.T + turn


def test_the_farthest_come_first_and_those_alike_not_at_all():
    poses = np.array([bent(angle, 3.0 * angle) for angle in (0.0, 0.4, 1.5, 1.5, -1.0, 0.01)])
    assert far_poses.differing(bent(0.0), poses, 1, 0.02) == [2]
    assert far_poses.differing(bent(0.0), poses, 2, 0.02) == [2, 4]
    assert far_poses.differing(bent(0.0), poses, 9, 0.02) == [1, 2, 4]
    assert far_poses.differing(bent(0.0), poses[:1], 9, 0.02) == []


def test_distances_leave_out_place_and_turn():
    poses = np.array([bent(0.8, 2.0), bent(0.8), bent(0.2)])
    assert np.allclose(far_poses.distances_from(bent(0.8), poses)[:2], 0.0, atol=1e-6)
    assert far_poses.distances_from(bent(0.8), poses)[2] > 0.05
