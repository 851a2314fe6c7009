# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits a mesh onto another by turns of closest points and the solver, from weak springs to stiff ones.

After Amberg, Romdhani, Vetter, Optimal Step Nonrigid ICP Algorithms for Surface Registration (2007), with the energy of
mean-value encodings in place of theirs: parts turn as far as the pairs say before closest points count at all.
"""

import collections

import numpy as np

from ...errors import SceneError
from ...scene.surface import Surface
from ...solver import native_loader, session

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
