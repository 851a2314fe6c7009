# SPDX-License-Identifier: GPL-3.0-or-later
"""How far limbs reach: handles that are farther apart than the limbs between them are long are held back."""

import itertools
from dataclasses import dataclass

import numpy as np

from ...scene.core import whole_mesh

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
