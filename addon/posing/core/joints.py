# SPDX-License-Identifier: GPL-3.0-or-later
"""How much lengths count where: much in limbs, little at the joints between them (E = 1/2 sum s_i |stretch of i|^2).

Each gives n float64 above 0. Limbs thirty times: with a hundred a cold solve of a fine mesh no longer finds its way,
with a thousand elbows do not bend.
"""

import numpy as np

from ...scene.core import motion, whole_mesh
from ...scene.core.point_sets import bounding_box_diagonal

STIFF = 30.0

#: Of the weights that a vertex has, the share of its segment's bones: here limbs begin, and are whole.
FROM, TO = 0.6, 0.95

#: A knee or elbow: the side on which it folds, the other one, and a strip of this power of a sine along its axis, which
#: keeps it from bending sideways. What it hangs on turns more freely: else a knee bends where a hip would have to.
INNER, OUTER, SIDE, NARROW, AXIS, BALL = 0.3, 3.0, 100.0, 6, 0.7, 0.3

#: Shares of both halves by which a vertex is at the joint between them.
LEAST = 0.02

#: Limbs whose halves have a greater cosine than this (3 degrees) are straight.
STRAIGHT = 0.9986

#: The lower half is longer than this share of the upper one: what ends sooner is a bone that helps at the joint.
SHORTEST_HALF = 0.33

#: Where more limbs meet than a body has, lengths still count.
SOFTEST = 0.05

#: Degrees by which a pose bends a surface over 1 % of the mesh's size: a limb bends less, a joint more.
RIGID, BENT = 4.0, 16.0

#: Edges that are shorter, as a share of the mesh's size, tell no more than ones of this length.
SHORTEST = 0.004


def by_weights(rest, segments, hinges=()):
    """(n factors, n numbers of the segment that has most of each vertex, -1 for none; n bool, whether it is no joint).

    rest: n x 3; segments: {name: [(vertex indices, weights), ...] of its bones}. What no bone carries is no limb.
    hinges: [(names of a limb's upper and lower half, unit vector along it, unit vector to where its joint points)]
    """
    count, wanted = len(rest), {name for hinge in hinges for name in hinge[:2]}
    most, total, of_hinges, part_of = np.zeros(count), np.zeros(count), {}, np.full(count, -1)
    for number, (name, bones) in enumerate(segments.items()):
        own = sum((np.bincount(*bone, count) for bone in bones), np.zeros(count))
        part_of[own > most] = number
        np.maximum(most, own, out=most)
        total += own
        if name in wanted:
            of_hinges[name] = own
    total[total <= 0.0] = 1.0
    factors = 1.0 + (STIFF - 1.0) * _smooth((most / total - FROM) / (TO - FROM))
    for upper, lower, along, way in hinges:
        _bend_one_way(factors, rest, of_hinges[upper] / total, of_hinges[lower] / total, along, way)
    return np.maximum(factors, SOFTEST), part_of, most > FROM * total


def freedom(factors):
    """n float64, 0 to 1: how much of n factors is missing to those of limbs."""
    return np.clip(1.0 - np.log(factors) / np.log(STIFF), 0.0, 1.0)


def _bend_one_way(factors, rest, upper, lower, along, way):
    """upper, lower: n shares of a limb's halves. Writes to n `factors`, at the joint and at what the limb hangs on."""
    factors[(upper > LEAST) & (upper < 1.0 - LEAST) & (lower <= LEAST)] *= BALL
    joint = np.flatnonzero((upper > LEAST) & (lower > LEAST) & (upper + lower > FROM))
    if not len(joint):
        return
    places = rest[joint] @ np.stack([way, np.cross(along, way)], axis=1)
    low, high = places.min(axis=0), places.max(axis=0)
    places -= low + (AXIS, 0.5) * (high - low)
    outward = places[:, 0] / np.maximum(np.linalg.norm(places, axis=1), 1e-12)
    soft = np.where(outward > 0.0, OUTER, INNER)
    factors[joint] = soft * (SIDE / soft) ** (1.0 - outward**2) ** NARROW


def hinge(begin, joint, end, forward):
    """(unit vector along a limb, unit vector to where its joint points) or None if nothing tells; the places are of its
    ends and of the joint between them in the rest pose, which goes on bending as it is bent. forward: where a straight
    one points, or None."""
    if np.linalg.norm(end - joint) <= SHORTEST_HALF * np.linalg.norm(joint - begin):
        return None
    halves = motion.unit(joint - begin), motion.unit(end - joint)
    along = motion.unit(end - begin)
    way = forward if halves[0] @ halves[1] > STRAIGHT else joint - begin
    if way is None:
        return None
    way = way - (way @ along) * along
    if np.linalg.norm(way) <= (1.0 - STRAIGHT) * np.linalg.norm(end - begin):
        return None
    # Matrices of a moving rig are rounded otherwise in each frame: what is bound shall not depend on that.
    return along.round(3), motion.unit(way).round(3)


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
