# SPDX-License-Identifier: GPL-3.0-or-later
"""How much lengths count where: much in limbs, little at the joints between them (E = 1/2 sum s_i |stretch of i|^2);
and how far limbs reach: handles that are farther apart than the limbs between them are long are held back.

Factors are n float64 above 0. Limbs thirty times: with a hundred a cold solve of a fine mesh no longer finds its way,
with a thousand elbows do not bend.
"""

import itertools
from dataclasses import dataclass

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


#: A limb is pulled to so many times its length, no farther; less than this share of it is rounding. So often the one
#: that is pulled farthest is held back, where several hold each other.
LONGEST, VISIBLE, ROUNDS = 1.05, 1e-3, 100


@dataclass(frozen=True, eq=False)
class Limbs:
    """The parts of a mesh that bend against each other, as a tree."""

    part_of: np.ndarray  # n int, of each vertex, -1 for none, and at joints: what is held there may go anywhere
    up: list  # of each part [itself, the part that it hangs on, the one that this hangs on, ...]
    joints: np.ndarray  # p x 3 float64, where it hangs on that at rest; no numbers where the two do not touch

    def way(self, first, second):
        """(how many joints are between part `first` and the part that both hang on, places of all joints on the way to
        part `second`); None where that is not known."""
        up, down = self.up[first].copy(), self.up[second].copy()
        if up[-1] != down[-1]:
            return None
        while up and down and up[-1] == down[-1]:
            up.pop()
            down.pop()
        places = self.joints[[*up, *reversed(down)]]
        return (len(up), places) if len(places) and np.isfinite(places).all() else None


@dataclass(frozen=True, eq=False)
class Limits:
    """m pairs of vertices with joints between them."""

    vertices: np.ndarray  # m x 2 int
    handles: np.ndarray  # m x 2 int: which hold them, -1 for what cannot move
    lengths: np.ndarray  # m float64: of the limbs from one to the other
    shares: np.ndarray  # m x 2 float64: how much each gives way. The more, the more joints it is from what both hang on

    def held_back(self, places, moving):
        """{number of a handle: shift (3,)} of those that are pulled too far. places: m x 2 x 3 of the vertices;
        moving: numbers of handles that are no pins."""
        is_free = np.isin(self.handles, moving)
        shares = self.shares * is_free
        shares = np.where(shares.any(axis=1, keepdims=True), shares, is_free)
        shares, places, shifts = shares / np.maximum(shares.sum(axis=1, keepdims=True), 1e-9), places.copy(), {}
        for _ in range(ROUNDS):
            across = places[:, 1] - places[:, 0]
            distances = np.linalg.norm(across, axis=1)
            excess = np.where(is_free.any(axis=1), distances / self.lengths - LONGEST, 0.0)
            if excess.max(initial=0.0) <= VISIBLE:
                break
            worst = int(excess.argmax())
            back = across[worst] * (1.0 - LONGEST * self.lengths[worst] / distances[worst])
            for number, share in zip(self.handles[worst].tolist(), shares[worst] * (1.0, -1.0), strict=True):
                if share:
                    places[self.handles == number] += share * back
                    shifts[number] = shifts.get(number, 0.0) + share * back
        return shifts


def limbs(rest, corners, starts, part_of, is_whole, up):
    """Limbs of n x 3 `rest`: joints are in the middle of where two parts meet. is_whole: n bool, not at a joint."""
    ends, above = whole_mesh.edge_ends(corners, starts), np.array([(*way, -1)[1] for way in up])
    first, second = np.concatenate([corners, ends]), np.concatenate([ends, corners])
    part, other = part_of[first], part_of[second]
    meets = (part >= 0) & (other >= 0) & (above[part] == other)
    middles, part = 0.5 * (rest[first[meets]].astype(np.float64) + rest[second[meets]]), part[meets]
    with np.errstate(invalid='ignore'):
        columns = [np.bincount(part, each, len(above)) / np.bincount(part, None, len(above)) for each in middles.T]
    return Limbs(np.where(is_whole, part_of, -1), up, np.stack(columns, axis=1))


def limits(of, rest, holders):
    """The Limits of each two holders with no common part. holders: {handle, or -1 for what is fixed: vertices}."""
    held, found = {}, []
    for number, vertices in holders.items():
        parts = of.part_of[vertices]
        held[number] = {part: vertices[parts == part] for part in np.unique(parts).tolist() if part >= 0}
    for pair in itertools.combinations(held, 2):
        one, other = (held[number] for number in pair)
        ways = []
        for parts in itertools.product(one, other) if one.keys().isdisjoint(other) else ():
            way = of.way(*parts)
            if way is not None:
                share, joints = way[0] / len(way[1]), way[1]
                sides = (one[parts[0]], joints[0]), (other[parts[1]], joints[-1])
                ends = [int(each[np.linalg.norm(rest[each] - place, axis=1).argmin()]) for each, place in sides]
                line = np.diff([rest[ends[0]], *joints, rest[ends[1]]], axis=0)
                ways.append((float(np.linalg.norm(line, axis=1).sum()), ends, pair, (share, 1.0 - share)))
        found += [min(ways)] if ways else []
    lengths, *pairs = (np.array([each[column] for each in found]) for column in range(4))
    vertices, handles, shares = (each.reshape(-1, 2) for each in pairs)
    return Limits(vertices.astype(int), handles, lengths, shares)
