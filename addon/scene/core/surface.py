# SPDX-License-Identifier: GPL-3.0-or-later
"""Nearest points on a triangle mesh, for many points at once, in numpy alone."""

import numpy as np

from ...errors import InvalidMotionError
from .rigid import unit

#: Triangles in a leaf at most, and points that are looked up in one go.
LEAF, POINTS = 8, 20_000


class Surface:
    """Triangles in a binary tree of bounding boxes, each half of whose triangles go to either side.

    vertices  (n, 3); triangles  (t, 3) vertex numbers; degenerate ones are points or lines.
    Raises InvalidMotionError where there are no triangles, or vertices are no numbers.
    """

    def __init__(self, vertices, triangles):
        self.vertices = np.array(vertices, np.float64)
        if not np.isfinite(self.vertices).all():
            raise InvalidMotionError("The mesh has vertices at places that are not numbers. Move or delete them.")
        if len(triangles) == 0:
            raise InvalidMotionError("The mesh has no faces, so there is no surface to match to. Give it faces.")
        self.triangles = np.array(triangles, np.int64)
        self._corners = self.vertices[self.triangles]
        self._crosses = np.cross(*(self._corners[:, k] - self._corners[:, 0] for k in (1, 2)))
        self._middles = self._corners.mean(axis=1)
        self._radii = np.linalg.norm(self._corners - self._middles[:, None], axis=2).max(axis=1) * (1.0 + 1e-9)
        self._make_tree()

    def nearest(self, points, normals=None, cosine=0.0):
        """(triangle (k,), barycentric (k, 3), point (k, 3), distance (k,)) of points (k, 3) without NaN.

        normals: (k, 3) unit, or None. With them, only triangles count whose normals are turned from that of the point
        by less than the arc cosine of `cosine`. What has none has distance inf, its triangle and point mean nothing.
        """
        points = np.asarray(points, float)
        parts = [slice(begin, begin + POINTS) for begin in range(0, len(points), POINTS)] or [slice(0, 0)]
        found = [self._nearest(points[part], None if normals is None else normals[part], cosine) for part in parts]
        triangle, shares, distance = (np.concatenate(each) for each in zip(*found, strict=True))
        return triangle, shares, np.einsum("kc,kcj->kj", shares, self._corners[triangle]), distance

    def normals(self):
        """(n, 3) unit normals of the vertices: of their faces, by area; of unused ones (0, 0, 1)."""
        result = np.zeros_like(self.vertices)
        for corner in range(3):
            np.add.at(result, self.triangles[:, corner], self._crosses)
        result[~result.any(axis=1)] = [0.0, 0.0, 1.0]
        return unit(result)

    def samples(self, count):
        """(points (count, 3), normals (count, 3)) spread over the surface by area, always the same ones."""
        areas = np.linalg.norm(self._crosses, axis=1)
        if not areas.sum() > 0.0:
            raise InvalidMotionError("The mesh has no area: all its triangles are points or lines.")
        ends = np.cumsum(areas) / areas.sum()
        chosen = np.minimum(np.searchsorted(ends, (np.arange(count) + 0.5) / count), len(areas) - 1)
        rng = np.random.default_rng(0)
        u, v = np.sqrt(rng.random(count)), rng.random(count)
        shares = np.stack([1.0 - u, u * (1.0 - v), u * v], axis=1)
        return np.einsum("kc,kcj->kj", shares, self._corners[chosen]), unit(self._crosses[chosen])

    def _make_tree(self):
        """_levels: (low, high, triangle near the middle) of the boxes, from the root; _leaves: (l, LEAF) triangles."""
        groups = np.arange(len(self.triangles))[None]
        low, high = self._corners.min(axis=1), self._corners.max(axis=1)
        self._levels = []
        while True:
            boxes = low[groups].min(axis=1), high[groups].max(axis=1)
            from_middle = self._middles[groups] - 0.5 * (boxes[0] + boxes[1])[:, None]
            central = np.linalg.norm(from_middle, axis=2).argmin(axis=1)
            self._levels.append((*boxes, groups[np.arange(len(groups)), central]))
            if groups.shape[1] <= LEAF:
                break
            axis = (boxes[1] - boxes[0]).argmax(axis=1)
            order = self._middles[groups, axis[:, None]].argsort(axis=1, kind="stable")
            groups = np.take_along_axis(groups, order, axis=1)
            if groups.shape[1] % 2:  # filled up with the last one again
                groups = np.concatenate([groups, groups[:, -1:]], axis=1)
            groups = groups.reshape(2 * len(groups), -1)
        self._leaves = groups

    def _nearest(self, points, normals, cosine):
        """(triangle (k,), barycentric (k, 3), distance (k,)); goes through the tree with all points, level by level."""
        units = None if normals is None else unit(self._crosses)
        reach = np.full(len(points), np.inf)  # the surface is no farther than this
        rows, nodes = np.arange(len(points)), np.zeros(len(points), np.int64)
        for depth, (low, high, central) in enumerate(self._levels):
            if depth:
                rows, nodes = np.repeat(rows, 2), (2 * nodes[:, None] + [0, 1]).ravel()
            at = points[rows]
            there = central[nodes]
            known = np.linalg.norm(self._middles[there] - at, axis=1)
            if units is not None:
                known[np.einsum("pj,pj->p", units[there], normals[rows]) <= cosine] = np.inf
            reach = np.minimum(reach, _least(known, rows, len(points)) * (1.0 + 1e-12))
            gaps = np.maximum(np.maximum(low[nodes] - at, at - high[nodes]), 0.0)
            near = np.linalg.norm(gaps, axis=1) <= reach[rows]
            rows, nodes = rows[near], nodes[near]
        candidates = self._leaves[nodes].ravel()
        rows = np.repeat(rows, self._leaves.shape[1])
        near = np.linalg.norm(self._middles[candidates] - points[rows], axis=1) <= reach[rows] + self._radii[candidates]
        rows, candidates = rows[near], candidates[near]
        if units is not None:
            compatible = np.einsum("pj,pj->p", units[candidates], normals[rows]) > cosine
            rows, candidates = rows[compatible], candidates[compatible]
        return self._nearest_of(points, rows, candidates)

    def _nearest_of(self, points, rows, candidates):
        """As _nearest(), of pairs: point rows[i], ascending, and triangle candidates[i]."""
        shares = nearest_on_triangles(points[rows], self._corners[candidates])
        away = np.linalg.norm(np.einsum("pc,pcj->pj", shares, self._corners[candidates]) - points[rows], axis=1)
        order = np.lexsort((candidates, away, rows))
        order = order[_first_of_each(rows[order])]
        found = rows[order]
        triangle, distance = np.zeros(len(points), np.int64), np.full(len(points), np.inf)
        barycentric = np.zeros((len(points), 3))
        triangle[found], barycentric[found], distance[found] = candidates[order], shares[order], away[order]
        return triangle, barycentric, distance


def _least(values, rows, count):
    """(count,): the least of the values with each row, rows ascending; inf where there is none."""
    result = np.full(count, np.inf)
    if len(rows):
        first = _first_of_each(rows)
        result[rows[first]] = np.minimum.reduceat(values, first)
    return result


def _first_of_each(rows):
    """Where in `rows`, ascending, each number comes first."""
    return np.flatnonzero(np.diff(rows, prepend=-1))


def outward(points, normals):
    """normals (n, 3) of points (n, 3) spread evenly over a closed surface, all turned round where they look inward."""
    return normals if ((points - points.mean(axis=0)) * normals).sum() > 0.0 else -normals


def nearest_on_triangles(points, corners):
    """(..., 3) barycentric coordinates of the points of triangles (..., 3, 3) nearest to points (..., 3).

    Ericson, Real-Time Collision Detection, 2005, 5.1.5; of degenerate triangles a point on one of their edges.
    """
    a, b, c = corners[..., 0, :], corners[..., 1, :], corners[..., 2, :]
    ab, ac, ap = b - a, c - a, points - a
    d1, d2 = (ab * ap).sum(-1), (ac * ap).sum(-1)
    d3, d4 = d1 - (ab * ab).sum(-1), d2 - (ab * ac).sum(-1)
    d5, d6 = d1 - (ab * ac).sum(-1), d2 - (ac * ac).sum(-1)
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2

    def share(above, below):
        return np.where(below > 0.0, above / np.where(below > 0.0, below, 1.0), 0.0).clip(0.0, 1.0)

    on_ab, on_ac, on_bc = share(d1, d1 - d3), share(d2, d2 - d6), share(d4 - d3, (d4 - d3) + (d5 - d6))
    total = va + vb + vc
    inside = np.where(total > 0.0, 1.0 / np.where(total > 0.0, total, 1.0), 0.0)
    zero, one = np.zeros_like(d1), np.ones_like(d1)
    cases = [
        ((d1 <= 0) & (d2 <= 0), (one, zero, zero)),
        ((d3 >= 0) & (d4 <= d3), (zero, one, zero)),
        ((d6 >= 0) & (d5 <= d6), (zero, zero, one)),
        ((vc <= 0) & (d1 >= 0) & (d3 <= 0), (1.0 - on_ab, on_ab, zero)),
        ((vb <= 0) & (d2 >= 0) & (d6 <= 0), (1.0 - on_ac, zero, on_ac)),
        ((va <= 0) & (d4 >= d3) & (d5 >= d6), (zero, 1.0 - on_bc, on_bc)),
        (total > 0.0, (va * inside, vb * inside, vc * inside)),
    ]
    conditions = [condition for condition, _ in cases]
    otherwise = (one, zero, zero)
    return np.stack([np.select(conditions, [v[k] for _, v in cases], otherwise[k]) for k in range(3)], axis=-1)
