# SPDX-License-Identifier: GPL-3.0-or-later
"""Which of many poses of a mesh differ most."""

import numpy as np

from ...scene.core.motion import fit_rotations


def differing(rest, poses, most, least):
    """Numbers of the poses, at most `most`, that differ most from the rest shape and from one another, ascending.

    rest, poses  (m, 3), (f, m, 3) of a few vertices; where the whole is, and how it is turned, does not count
    least  poses nearer to each other count as the same
    """
    distances, chosen = distances_from(rest, poses), []
    while len(chosen) < most and distances.max() > least:
        chosen.append(int(distances.argmax()))
        distances = np.minimum(distances, distances_from(poses[chosen[-1]], poses))
    return sorted(chosen)


def distances_from(pose, poses):
    """(f,) float64: how far (f, m, 3) poses are from one, (m, 3), root mean square after the best rigid motion."""
    pose = pose - pose.mean(axis=0)
    poses = poses - poses.mean(axis=1, keepdims=True)
    turned = pose @ np.swapaxes(fit_rotations(pose, poses), 1, 2)
    return np.sqrt(((poses - turned) ** 2).sum(axis=2).mean(axis=1))
