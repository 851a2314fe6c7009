# SPDX-License-Identifier: GPL-3.0-or-later
"""Nearest points on a triangle mesh, for many points at once, and samples of it."""

import numpy as np

from ..errors import InvalidMotionError
from ..solver import native_loader
from .core.motion import unit


class Surface:
    """vertices  (n, 3); triangles  (t, 3) vertex numbers; degenerate ones are points or lines.
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
        self._tree = native_loader.module().Surface(self.vertices, self.triangles)

    def nearest(self, points, normals=None, cosine=0.0):
        """(triangle (k,), barycentric (k, 3), point (k, 3), distance (k,)) of points (k, 3) without NaN: as of
        meanvalue.Surface, and the places themselves. Where there is none, triangle and point mean nothing."""
        triangle, shares, distance = self._tree.nearest(points, normals, cosine)
        return triangle, shares, np.einsum("kc,kcj->kj", shares, self._corners[triangle]), distance

    def normals(self):
        """(n, 3) unit normals of the vertices: of their faces, by area; of unused ones (0, 0, 1)."""
        result = np.zeros_like(self.vertices)
        for corner in range(3):
            np.add.at(result, self.triangles[:, corner], self._crosses)
        result[~result.any(axis=1)] = [0.0, 0.0, 1.0]
        return unit(result)

    def folded(self):
        """(t,) bool: triangles that look away from the normals of their corners: their surroundings'."""
        return np.einsum("tj,tj->t", self._crosses, self.normals()[self.triangles].sum(axis=1)) < 0.0

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
