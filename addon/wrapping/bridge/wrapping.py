# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits a mesh onto another by turns of closest points and the solver, from weak springs to stiff ones.

After Amberg, Romdhani, Vetter, Optimal Step Nonrigid ICP Algorithms for Surface Registration (2007), with the energy of
mean-value encodings in place of theirs: parts turn as far as the pairs say before closest points count at all.
"""

import collections
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ... import wording
from ...errors import SceneError
from ...scene.core import point_sets
from ...scene.core.motion import fit_rotations
from ...scene.surface import Surface
from ...solver import native_loader, session

#: Fewer pairs leave open how the mesh is turned.
LEAST_PAIRS = 3

#: Sizes of meshes that are said to lie over each other may differ by this factor, and their middles by this share.
ALIKE, BESIDE = 2.0, 0.5


@dataclass(frozen=True, eq=False)
class WrapInput:
    """A mesh whose faces stay, one whose shape it takes, and k pairs of points; without any, both lie over each other.
    All in the same space."""

    vertices: np.ndarray  # (n, 3) float64 of the mesh that is fitted
    triangles: np.ndarray  # (m, 3) int32
    target: np.ndarray  # (p, 3) float64 of the other
    target_triangles: np.ndarray  # (q, 3) int32
    picked: np.ndarray  # (k,) distinct vertices of the first
    points: np.ndarray  # (k, 3) where they belong on the other

    @cached_property
    def used(self):
        """Ascending numbers of the vertices that have faces."""
        return np.unique(self.triangles)

    @cached_property
    def diagonal(self):
        """Of the box around what is taken the shape of."""
        return point_sets.bounding_box_diagonal(self.target[np.unique(self.target_triangles)])

    def check(self):
        """@throws SceneError."""
        for points, triangles, name in (
            (self.vertices, self.triangles, "mesh that is fitted"),
            (self.target, self.target_triangles, "mesh that it is fitted onto"),
        ):
            if not len(triangles):
                raise SceneError(f"The {name} has no faces, so it has no surface to fit. Choose another mesh")
            if not np.isfinite(points).all():
                bad = np.count_nonzero(~np.isfinite(points).all(axis=1))
                raise SceneError(f"{wording.vertices(bad)} of the {name} are no numbers. Repair the mesh first")
            if point_sets.bounding_box_diagonal(points[np.unique(triangles)]) == 0.0:
                raise SceneError(f"All vertices of the {name} are in one place. Choose another mesh")
        count = len(self.picked)
        if count == 0:  # both must lie over each other
            boxes = [
                (points[used].min(axis=0), points[used].max(axis=0))
                for points, used in ((self.vertices, self.used), (self.target, np.unique(self.target_triangles)))
            ]
            sizes = [float(np.linalg.norm(high - low)) for low, high in boxes]
            apart = float(np.linalg.norm(np.subtract(sum(boxes[0]), sum(boxes[1])))) / 2.0
            if max(sizes) > ALIKE * min(sizes) or apart > BESIDE * max(sizes):
                raise SceneError(
                    "The meshes do not lie over each other. Pick pairs of points, or lay one over the other"
                )
            return
        if not np.isfinite(self.points).all():
            raise SceneError("The point of a pair is not a number. Remove that pair and pick it again")
        if self.picked.min() < 0 or self.picked.max() >= len(self.vertices):
            has = wording.vertices(len(self.vertices))
            raise SceneError(f"A pair names vertex {self.picked.max()}, and the mesh has {has}. Pick the pairs again")
        if len(np.unique(self.picked)) < count:
            raise SceneError("Two pairs name the same vertex, which cannot go to two places. Remove one of them")
        for places, where in ((self.vertices[self.picked], "mesh that is fitted"), (self.points, "other mesh")):
            if not point_sets.span_a_plane(places):
                pairs = f"The {wording.counted(count, 'pair')} on the {where} leave open how it is turned"
                raise SceneError(f"{pairs}. Pick at least {LEAST_PAIRS} that are not in one line")

    def start(self):
        """(n, 3): the mesh turned, scaled and moved so that its pairs are near their points.

        The scale is the median of how much longer the way from a pair to that nearest to it became: poses change what
        is near each other little. Turned by least squares (Kabsch 1976).
        """
        if not len(self.picked):
            return self.vertices.copy()
        places = self.vertices[self.picked]
        lengths, others = (np.linalg.norm(points[:, None] - points, axis=2) for points in (places, self.points))
        lengths[lengths == 0.0] = np.inf
        near = np.arange(len(places)), lengths.argmin(axis=1)
        turn, scale = fit_rotations(places, self.points), np.median(others[near] / lengths[near])
        return scale * (self.vertices - places.mean(axis=0)) @ turn.T + self.points.mean(axis=0)


#: How much all springs together count; of one it is this over their number, so that they give way alike at any
#: resolution. Each is tried until partners are as close as CLOSE, a share of the diagonal, on average, and taken if it
#: turns no more triangles over than the one before.
STRENGTHS, CLOSE = (1.5, 5.0, 15.0, 50.0, 150.0), 5e-4
#: Of the picked pairs while they alone pose the mesh: then they are met.
POSING = 1.0
#: Rounds of closest points at each strength at most, and what a round must gain for another one.
ROUNDS, GAIN = 6, 0.1
#: Partners look the same way to this cosine.
COSINE = 0.3
#: A vertex is no partner of a point that another place of the mesh is nearer to by this factor, give or take this share
#: of an edge: insides of mouths, eyes that the other does not have, and what is hidden behind.
NEARER, SLACK = 2.0, 0.5


#: positions: (n, 3) float64; distance: (n,) to the other surface, of vertices without faces 0; flipped: how many
#: triangles are folded that were not.
Wrapped = collections.namedtuple("Wrapped", "positions distance flipped")


class Wrap:
    """share: how much is done, 0 to 1."""

    def __init__(self, given):
        given.check()
        self.given = given
        self.share = 0.0
        self._surface = Surface(given.target, given.target_triangles)
        self._normals = self._surface.normals()

    def work(self, execution):
        """Steps (see solver/job.py) to the Wrapped. @throws SceneError if no part comes near the other; SolverError."""
        given = self.given
        rest = shape = given.start()
        was_folded = Surface(rest, given.triangles).folded()
        self._execution = execution
        if len(given.picked):
            deformer = yield from self._bind(rest, given.picked, np.full(len(given.picked), POSING))
            shape = yield from self._solve(deformer, given.points)
        best = None
        for number, strength in enumerate(STRENGTHS):
            self.share = (number + 0.5) / (len(STRENGTHS) + 1)
            springs = np.full(len(given.used), strength / len(given.used))
            deformer = yield from self._bind(rest, given.used, springs)
            last = np.inf
            for _ in range(ROUNDS):
                points, weights, away = self._partners(shape)
                if not weights.any():
                    raise SceneError(
                        "No part of the mesh comes near the other one. Pick more pairs of points, or lay one over the "
                        "other"
                    )
                shape = yield from self._solve(deformer, points, weights, shape)
                if away > (1.0 - GAIN) * last:
                    break
                last = away
            flipped = int(np.count_nonzero(Surface(shape, given.triangles).folded() & ~was_folded))
            if best is not None and flipped > best[1]:
                break
            best = shape, flipped
            if away < CLOSE * given.diagonal:
                break
        shape, flipped = best
        distance = np.zeros(len(shape))
        distance[given.used] = self._surface.nearest(shape[given.used])[3]
        self.share = 1.0
        return Wrapped(shape, distance, flipped)

    def _bind(self, rest, anchors, strengths):
        start, triangles = native_loader.module().start_bind, self.given.triangles
        execution = self._execution
        return session.steps(start, rest, triangles, anchors, strengths=strengths, execution=execution)

    def _solve(self, deformer, targets, weights=None, start=None):
        solution = yield from session.steps(
            deformer.start_solve,
            np.ascontiguousarray(targets),
            weights=weights,
            start=start,
            execution=self._execution,
            refused=session.REFUSED_POSE,
        )
        return session.finite(solution.vertices, "Pick more pairs of points")

    def _partners(self, shape):
        """(points (u, 3), weights (u,), mean distance to them) of the used vertices; picked ones have their own."""
        given, used = self.given, self.given.used
        surface = Surface(shape, given.triangles)
        normals = surface.normals()[used]
        triangle, shares, points, away = self._surface.nearest(shape[used], normals, COSINE)
        found = np.isfinite(away)
        facing = np.einsum("kc,kcj->kj", shares, self._normals[given.target_triangles[triangle]])[found]
        facing /= np.maximum(np.linalg.norm(facing, axis=1, keepdims=True), 1e-300)
        nearest = surface.nearest(points[found], facing, COSINE)[3]
        corners = given.triangles
        lengths, ends = np.linalg.norm(shape[corners] - shape[np.roll(corners, -1, axis=1)], axis=2), corners.ravel()
        edges = np.bincount(ends, lengths.ravel(), len(shape)) / np.maximum(np.bincount(ends, None, len(shape)), 1)
        found[found] = away[found] <= NEARER * nearest + SLACK * edges[used[found]]
        mean = float(away[found].mean()) if found.any() else 0.0
        points[~found] = shape[used[~found]]
        weights = found.astype(np.float64)
        at = np.searchsorted(used, given.picked[np.isin(given.picked, used)])
        points[at], weights[at] = given.points[np.isin(given.picked, used)], 1.0
        return points, weights, mean
