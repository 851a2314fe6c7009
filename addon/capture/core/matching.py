# SPDX-License-Identifier: GPL-3.0-or-later
"""Each marker's place on the mesh: a vertex of its own, and where the marker is from it."""

from dataclasses import dataclass

import numpy as np

from ...scene.core import checks
from ...scene.core.surface import Surface


@dataclass(frozen=True, eq=False)
class Match:
    """Of each of m markers; of missing ones vertex -1 and NaN."""

    #: (m,) the anchor vertex, another one for each marker.
    vertex: np.ndarray
    #: (m, 3) from the anchor vertex to the marker, at rest.
    offset: np.ndarray
    #: (m,) from the marker to the surface, or to a vertex that was given.
    distance: np.ndarray


def match_to_surface(markers, vertices, triangles, fixed=None):
    """The `Match` of markers with the surface nearest to them.

    Anchor vertices are those nearest to the surface points. Where markers compete for one, the first has it, and the
    next takes the nearest that is left.

    markers  (m, 3) in the mesh's space, aligned, NaN where missing; vertices  (n, 3); triangles  (t, 3); fixed
    {marker number: vertex} that are given.
    Raises InvalidMotionError for meshes without surface or with less used vertices than markers.
    """
    markers = checks.points(markers, "the markers")
    surface = Surface(vertices, triangles)
    fixed = fixed or {}
    known = [number for number in np.flatnonzero(~np.isnan(markers[:, 0])) if number not in fixed]
    free = np.setdiff1d(surface.triangles, list(fixed.values()))
    if len(free) < len(known):
        raise checks.InvalidMotionError(
            f"The mesh has {len(free)} vertices for {len(known)} markers, and each needs one of its own: subdivide it."
        )
    vertex, distance = np.full(len(markers), -1, np.int64), np.full(len(markers), np.nan)
    _, _, points, distance[known] = surface.nearest(markers[known])
    for number, point in zip(known, points, strict=True):
        nearest = ((surface.vertices[free] - point) ** 2).sum(axis=1).argmin()
        vertex[number] = free[nearest]
        free = np.delete(free, nearest)
    for number, given in fixed.items():
        vertex[number] = given
        distance[number] = np.linalg.norm(markers[number] - surface.vertices[given])
    offset = np.where(vertex[:, None] < 0, np.nan, markers - surface.vertices[vertex])
    return Match(vertex, offset, distance)
