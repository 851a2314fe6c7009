# SPDX-License-Identifier: GPL-3.0-or-later
"""What is fitted onto what, checked, and where it starts."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ... import wording
from ...errors import SceneError
from ...scene.core import point_sets
from ...scene.core.motion import fit_rotations

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
