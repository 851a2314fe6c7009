# SPDX-License-Identifier: GPL-3.0-or-later
"""Nearest points on a triangle mesh, for many points at once, in numpy alone."""

import heapq

import numpy as np

from . import checks

#: Triangles in a block, and pairs of points and triangles that are looked at in one go.
BLOCK, PAIRS = 32, 400_000


class Surface:
    """Triangles in blocks with bounding boxes: a bounding volume hierarchy of two levels.

    vertices  (n, 3) finite; triangles  (t, 3) vertex numbers, at least one; degenerate ones are points or lines.
    Raises InvalidMotionError for other input.
    """

    def __init__(self, vertices, triangles):
        self.vertices = checks.points(vertices, "the mesh", missing_allowed=False)
        triangles = np.asarray(triangles)
        if triangles.ndim != 2 or triangles.shape[1] != 3 or not len(triangles) or triangles.dtype.kind not in "iu":
            raise checks.InvalidMotionError(
                f"The mesh must have triangles, an array of whole numbers t x 3, but this one is {triangles.dtype} "
                f"{triangles.shape}. A mesh without faces has no surface to match markers to."
            )
        if triangles.min() < 0 or triangles.max() >= len(self.vertices):
            raise checks.InvalidMotionError(
                f"A triangle of the mesh names vertex {triangles.max()}, but there are {len(self.vertices)}."
            )
        self.triangles = triangles.astype(np.int64)
        corners = self.vertices[self.triangles]
        order = np.argsort(_along_a_curve(corners.mean(axis=1)), kind="stable")
        # The last block is filled up with its last triangle.
        padded = np.concatenate([order, np.full(-len(order) % BLOCK, order[-1])])
        self._blocks = padded.reshape(-1, BLOCK)
        in_blocks = corners[self._blocks].reshape(len(self._blocks), -1, 3)
        self._low, self._high = in_blocks.min(axis=1), in_blocks.max(axis=1)

    def nearest(self, points):
        """(triangle (k,), barycentric (k, 3), point (k, 3), distance (k,)) of points (k, 3) without NaN."""
        points = np.asarray(points, float)
        triangle, shares = np.zeros(len(points), np.int64), np.zeros((len(points), 3))
        rows = max(1, PAIRS // len(self._blocks))
        for begin in range(0, len(points), rows):
            part = slice(begin, begin + rows)
            triangle[part], shares[part] = self._nearest(points[part])
        point = np.einsum("kc,kcj->kj", shares, self.vertices[self.triangles[triangle]])
        return triangle, shares, point, np.linalg.norm(point - points, axis=1)

    def normals(self):
        """(n, 3) unit normals of the vertices: of their faces, by area; of unused ones (0, 0, 1)."""
        corners = self.vertices[self.triangles]
        areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        result = np.zeros_like(self.vertices)
        for corner in range(3):
            np.add.at(result, self.triangles[:, corner], areas)
        result[~result.any(axis=1)] = [0.0, 0.0, 1.0]
        return _unit(result)

    def samples(self, count):
        """(points (count, 3), normals (count, 3)) spread over the surface by area, always the same ones."""
        corners = self.vertices[self.triangles]
        crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        areas = np.linalg.norm(crosses, axis=1)
        if not areas.sum() > 0.0:
            raise checks.InvalidMotionError("The mesh has no area: all its triangles are points or lines.")
        ends = np.cumsum(areas) / areas.sum()
        chosen = np.minimum(np.searchsorted(ends, (np.arange(count) + 0.5) / count), len(areas) - 1)
        rng = np.random.default_rng(0)
        u, v = np.sqrt(rng.random(count)), rng.random(count)
        shares = np.stack([1.0 - u, u * (1.0 - v), u * v], axis=1)
        return np.einsum("kc,kcj->kj", shares, corners[chosen]), _unit(crosses[chosen])

    def _nearest(self, points):
        gaps = np.maximum(np.maximum(self._low - points[:, None], points[:, None] - self._high), 0.0)
        bounds = np.sqrt((gaps**2).sum(axis=2))
        best = np.full(len(points), np.inf)
        triangle, shares = np.zeros(len(points), np.int64), np.zeros((len(points), 3))
        rows = np.arange(len(points))
        self._look(points, rows, bounds.argmin(axis=1), best, triangle, shares)
        rows, blocks = np.nonzero(bounds < best[:, None])
        order = np.argsort(bounds[rows, blocks], kind="stable")
        rows, blocks = rows[order], blocks[order]
        step = PAIRS // BLOCK // 4
        for begin in range(0, len(rows), step):
            part = slice(begin, begin + step)
            still = bounds[rows[part], blocks[part]] < best[rows[part]]
            self._look(points, rows[part][still], blocks[part][still], best, triangle, shares)
        return triangle, shares

    def _look(self, points, rows, blocks, best, triangle, shares):
        """Looks at whole blocks, for point rows[i] at blocks[i], and keeps what is nearer than `best`."""
        if not len(rows):
            return
        candidates = self._blocks[blocks]
        found = nearest_on_triangles(points[rows][:, None], self.vertices[self.triangles[candidates]])
        there = np.einsum("rbc,rbcj->rbj", found, self.vertices[self.triangles[candidates]])
        distances = np.linalg.norm(there - points[rows][:, None], axis=2)
        pick = distances.argmin(axis=1)
        here = np.arange(len(rows))
        distances = distances[here, pick]
        # A point may have several blocks here: the farthest is written first, the nearest last.
        order = np.argsort(-distances, kind="stable")
        order = order[distances[order] < best[rows[order]]]
        best[rows[order]] = distances[order]
        triangle[rows[order]] = candidates[order, pick[order]]
        shares[rows[order]] = found[order, pick[order]]


def along_from(seeds, points, reach):
    """(n,): lengths of the shortest ways from points (n, 3) where seeds (n,) is true, by steps of at most `reach` from
    one point to another; infinite where there is none (Dijkstra 1959)."""
    squares = (points**2).sum(axis=1)
    apart = squares[:, None] - 2.0 * points @ points.T + squares
    begins, ends = np.nonzero(apart < reach**2)
    lengths = np.sqrt(np.maximum(apart[begins, ends], 0.0)).tolist()
    first, ends = np.searchsorted(begins, np.arange(len(points) + 1)).tolist(), ends.tolist()
    result = np.where(seeds, 0.0, np.inf).tolist()
    queue = [(0.0, number) for number in np.flatnonzero(seeds).tolist()]
    while queue:
        length, number = heapq.heappop(queue)
        if length > result[number]:
            continue
        for k in range(first[number], first[number + 1]):
            longer = length + lengths[k]
            if longer < result[ends[k]]:
                result[ends[k]] = longer
                heapq.heappush(queue, (longer, ends[k]))
    return np.array(result)


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


def _unit(vectors):
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300)


def _along_a_curve(points):
    """(t,) places along Morton's curve, 10 bits an axis: near ones are near in space."""
    extent = np.ptp(points, axis=0)
    cells = ((points - points.min(axis=0)) / np.where(extent > 0.0, extent, 1.0) * 1023.0).astype(np.int64)
    for shift, mask in ((16, 0x030000FF), (8, 0x0300F00F), (4, 0x030C30C3), (2, 0x09249249)):
        cells = (cells | (cells << shift)) & mask
    return cells[:, 0] | (cells[:, 1] << 1) | (cells[:, 2] << 2)
