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
    #: (m, 3) the point of the surface nearest to the marker.
    point: np.ndarray
    #: (m, 3) from the anchor vertex to the marker, in the surface's local frame: along two tangents and the normal.
    offset: np.ndarray
    #: (m,) from the marker to the surface.
    distance: np.ndarray
    #: (m, 3, 3) that frame at rest; its columns are the tangents and the normal.
    frame: np.ndarray


def match_to_surface(markers, vertices, triangles):
    """The `Match` of markers with the surface nearest to them.

    Anchor vertices are those nearest to the surface points; where markers compete for one, they are given so that the
    sum of the distances from surface points to anchor vertices is least (Hungarian method, Kuhn 1955).

    markers  (m, 3) in the mesh's space, aligned, NaN where missing; vertices  (n, 3); triangles  (t, 3).
    Raises InvalidMotionError for meshes without surface or with less used vertices than markers.
    """
    markers = checks.points(markers, "the markers")
    surface = Surface(vertices, triangles)
    normals = surface.normals()
    known = np.flatnonzero(~np.isnan(markers[:, 0]))
    used = np.unique(surface.triangles)
    if len(used) < len(known):
        raise checks.InvalidMotionError(
            f"The mesh has {len(used)} vertices for {len(known)} markers, and each needs one of its own: subdivide it."
        )
    result = Match(
        np.full(len(markers), -1, np.int64),
        *(np.full((len(markers), *shape), np.nan) for shape in ((3,), (3,), (), (3, 3))),
    )
    if not len(known):
        return result
    triangle, shares, point, distance = surface.nearest(markers[known])
    corners = surface.triangles[triangle]
    vertex = used[one_to_one(point, surface.vertices[used])]
    frame = _frames(np.einsum("kc,kcj->kj", shares, normals[corners]), surface.vertices[corners])
    result.vertex[known], result.point[known], result.distance[known] = vertex, point, distance
    result.frame[known] = frame
    result.offset[known] = np.einsum("kji,kj->ki", frame, markers[known] - surface.vertices[vertex])
    return result


def one_to_one(points, places):
    """(k,) which of places (n, 3), n >= k, each of points (k, 3) gets: all different, least sum of distances."""
    distances = np.empty((len(points), min(len(places), len(points))))
    nearest = np.empty(distances.shape, np.int64)
    for number, point in enumerate(points):
        squares = ((places - point) ** 2).sum(axis=1)
        # As many as there are points: were all others taken, one is left.
        count = distances.shape[1]
        some = np.argpartition(squares, count - 1)[:count] if count < len(places) else np.arange(count)
        some = some[np.lexsort((some, squares[some]))]
        nearest[number], distances[number] = some, np.sqrt(squares[some])
    chosen = nearest[:, 0].copy()
    if len(np.unique(chosen)) == len(chosen):
        return chosen
    # Only who competes, at first or after giving way, needs to be asked: whole groups that share a candidate.
    columns, inverse = np.unique(nearest, return_inverse=True)
    costs = np.full((len(points), len(columns)), np.inf)
    np.put_along_axis(costs, inverse.reshape(nearest.shape), distances, axis=1)
    return columns[_assignment(costs)]


def _assignment(costs):
    """(k,) the column of each row, all different, least sum; costs (k, n), n >= k, infinite where it may not be.

    Hungarian method by shortest augmenting paths (Jonker and Volgenant 1987), a row of numpy at each step.
    """
    rows, columns = costs.shape
    costs = np.where(np.isfinite(costs), costs, 1e6 * (1.0 + costs[np.isfinite(costs)].max()))
    of_row, of_column = np.zeros(rows + 1), np.zeros(columns + 1)
    owner = np.zeros(columns + 1, np.int64)  # rows and columns count from 1 here; 0 is none
    for row in range(1, rows + 1):
        owner[0], column = row, 0
        shortest = np.full(columns + 1, np.inf)
        before, done = np.zeros(columns + 1, np.int64), np.zeros(columns + 1, bool)
        while owner[column]:
            done[column] = True
            reduced = costs[owner[column] - 1] - of_row[owner[column]] - of_column[1:]
            better = ~done[1:] & (reduced < shortest[1:])
            shortest[1:][better] = reduced[better]
            before[1:][better] = column
            following = 1 + int(np.where(done[1:], np.inf, shortest[1:]).argmin())
            step = shortest[following]
            of_row[owner[done]] += step
            of_column[done] -= step
            shortest[~done] -= step
            column = following
        while column:
            owner[column] = owner[before[column]]
            column = before[column]
    result = np.empty(rows, np.int64)
    taken = np.flatnonzero(owner[1:])
    result[owner[1:][taken] - 1] = taken
    return result


def _frames(normals, corners):
    """(k, 3, 3) right-handed frames: last columns the normals (k, 3), first ones along edges of corners (k, 3, 3)."""
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.where(lengths > 1e-9, normals, face)  # where normals of corners cancel, the face's
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.where(lengths > 1e-300, normals / np.maximum(lengths, 1e-300), [0.0, 0.0, 1.0])
    tangent = corners[:, 1] - corners[:, 0]
    tangent = tangent - (tangent * normals).sum(axis=1, keepdims=True) * normals
    poor = np.linalg.norm(tangent, axis=1) <= 1e-12
    axis = np.eye(3)[np.abs(normals).argmin(axis=1)]
    tangent[poor] = np.cross(normals, axis)[poor]
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    return np.stack([tangent, np.cross(normals, tangent), normals], axis=2)
