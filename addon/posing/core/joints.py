# SPDX-License-Identifier: GPL-3.0-or-later
"""How much lengths count where: much in limbs, little at the joints between them (E = 1/2 sum s_i |stretch of i|^2).

Each gives n float64 between 1 and STIFF. Thirty times: with a hundred a cold solve of a fine mesh no longer finds its
way, with a thousand elbows do not bend.
"""

import numpy as np

from ...scene.core import motion, whole_mesh
from ...scene.core.point_sets import bounding_box_diagonal

STIFF = 30.0

#: Of the weights that a vertex has, the share of its segment's bones: here limbs begin, and are whole.
FROM, TO = 0.6, 0.95

#: Degrees by which a pose bends a surface over 1 % of the mesh's size: a limb bends less, a joint more.
RIGID, BENT = 4.0, 16.0

#: Edges that are shorter, as a share of the mesh's size, tell no more than ones of this length.
SHORTEST = 0.004


def by_weights(count, segments):
    """segments: [[(vertex indices, weights), ...] of the bones of one, ...]. What no bone carries is no limb."""
    most, total = np.zeros(count), np.zeros(count)
    for bones in segments:
        own = sum((np.bincount(*bone, count) for bone in bones), np.zeros(count))
        np.maximum(most, own, out=most)
        total += own
    share = np.divide(most, total, out=np.zeros(count), where=total > 0.0)
    return 1.0 + (STIFF - 1.0) * _smooth((share - FROM) / (TO - FROM))


def by_poses(rest, corners, starts, poses):
    """rest and each of the poses n x 3; corners, starts: as of scene.mesh_arrays.faces()."""
    pairs = np.sort(np.stack([corners, whole_mesh.edge_ends(corners, starts)], axis=1), axis=1)
    first, second = np.unique(np.concatenate([pairs, pairs[:, ::-1]]), axis=0).T  # each edge both ways
    rest = rest.astype(np.float64)
    across = rest[second] - rest[first]
    size = bounding_box_diagonal(rest)
    lengths = 100.0 * np.maximum(np.linalg.norm(across, axis=1) / size, SHORTEST)
    rate = np.zeros(len(rest))

    def gathered(values):
        """n x 9: of m x 9 values of edges the sums at the vertices that they begin at."""
        return np.stack([np.bincount(first, column, len(rest)) for column in values.T], axis=1)

    for pose in poses:
        turned = pose[second].astype(np.float64) - pose[first]
        covariance = gathered((turned[:, :, None] * across[:, None, :]).reshape(-1, 9))
        for _ in range(2):
            covariance += gathered(covariance[second])
        turns = motion.nearest_rotations(covariance.reshape(-1, 3, 3) + motion.TIE * size**2 * np.eye(3))
        cosine = 0.5 * ((turns[first] * turns[second]).sum(axis=(1, 2)) - 1.0)
        np.maximum.at(rate, first, np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))) / lengths)
    return STIFF ** (1.0 - _smooth((rate - RIGID) / (BENT - RIGID)))


def _smooth(share):
    share = np.clip(share, 0.0, 1.0)
    return share**2 * (3.0 - 2.0 * share)
