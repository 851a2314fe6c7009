# SPDX-License-Identifier: GPL-3.0-or-later
"""Which vertices of a mesh are one: those of open seams in one place, and what Merge Distance adds. The artist's mesh
is not changed. See scene/kept.py for an object's, whole_mesh.py for what is made of them."""

import numpy as np

from ... import wording
from ...errors import SceneError
from ...solver import native_loader
from . import point_sets, whole_mesh

#: Of the mesh's extent: a few steps of single precision, which is all that takes copies of a vertex apart.
ROUNDING = 4.0 * 2.0**-23

#: Of the faces' edges: where merging takes more of them away, it merges what is no seam.
MOST_COLLAPSED = 0.02

#: So many of the faces' edges are measured at most: a share of them, by steps that no triangle or quad has part in.
MOST_MEASURED, STEP = 200_000, 6

#: Of the mesh's size, and of its shortest edges: borders that are so near to each other are apart by mistake.
NEAR, NEAR_EDGES = 1e-3, 0.1
#: Of that: so near they are by mistake even where they are few; other ones may be tips of hair, or hems.
SURE = 0.1


def copies(rest, closes_seams, merge_distance, face_corners, face_starts):
    """n int: of n x 3 float32 `rest` one copy for all copies of a vertex; None where each is its own.

    closes_seams: as first_of_seams() of the core says; merge_distance: if > 0, all that are so near are copies.
    @throws SceneError where a place is not finite.
    """
    point_sets.require_finite(rest, "rest shape")
    if not closes_seams and merge_distance <= 0.0:
        return None
    if merge_distance > 0.0:
        first = first_of_place(rest, max(merge_distance, rounding(rest) if closes_seams else 0.0))
    else:
        first = native_loader.module().first_of_seams(rest, face_corners, face_starts, rounding(rest))
    return None if np.array_equal(first, np.arange(len(first), dtype=first.dtype)) else first.astype(np.int64)


def rounding(rest):
    """How far copies of a vertex may be apart for all that is known of single precision."""
    return ROUNDING * max(float(np.ptp(axis)) for axis in rest.T) if len(rest) else 0.0


def together(first, shapes, merge_distance):
    """What of `first`, as of copies(), lies together in all n x 3 `shapes`, unlike lips that a key opens; or None."""
    if first is None:
        return None
    count, first = len(first), first.astype(np.int64)  # numpy 1 has 32 bits on Windows
    joined = np.flatnonzero(np.bincount(first)[first] > 1)
    for shape in shapes:
        place = joined[first_of_place(shape[joined], max(merge_distance, 2.0 * rounding(shape)))]
        _, index, inverse = np.unique(first[joined] * count + place, return_index=True, return_inverse=True)
        first[joined] = joined[index[inverse.ravel()]]
    return None if np.array_equal(first, np.arange(count)) else first


def first_of_place(points, distance):
    """n int: for each of n x 3 points the lowest index of those that steps of at most `distance` lead to."""
    return native_loader.module().first_of_place(points, distance).astype(np.int64)


def require_no_more_than_seams(rest, face_corners, face_starts, merge_distance):
    """@throws SceneError, with a distance that does, if `merge_distance` takes too many of the faces' edges away."""
    lengths = edge_lengths(rest, face_corners, face_starts) if merge_distance > 0.0 and len(face_starts) else []
    collapsed = float((lengths <= merge_distance).mean()) if len(lengths) else 0.0
    if collapsed > MOST_COLLAPSED:
        raise SceneError(
            f"The Merge Distance {merge_distance:g} would merge {wording.share(collapsed)} of the mesh's edges to "
            f"points. Choose {harmless(lengths):g} or less in Advanced"
        )


def edge_lengths(rest, face_corners, face_starts):
    """Lengths, float64, of the faces' edges with ends apart; of a large mesh of some all over it."""
    some = slice(None, None, 1 + STEP * (len(face_corners) // MOST_MEASURED))
    ends = whole_mesh.edge_ends(face_corners, face_starts)[some]
    lengths = np.linalg.norm(rest[face_corners[some]].astype(np.float64) - rest[ends], axis=1)
    return lengths[lengths > 0.0]


def harmless(lengths):
    """The longest merge distance, rounded down to one figure, that takes no more than MOST_COLLAPSED of edges away."""
    longest = float(np.quantile(lengths, MOST_COLLAPSED, method="lower")) * (1.0 - 1e-6)
    figure = 10.0 ** np.floor(np.log10(longest))
    return float(f"{np.floor(longest / figure) * figure:.1g}")


def gaping(rest, face_corners, face_starts, first, surely=False):
    """(vertices, distance): ascending ones at edges of open borders that lie nearly in the place of others, and a
    merge distance that joins them.

    first: as of copies(), which are none of them; surely: only if they are very near, or most of the borders.
    """
    corners = face_corners if first is None else first[face_corners]
    edges = native_loader.module().border_edges(len(rest), corners, face_starts)
    lengths = edge_lengths(rest, face_corners, face_starts) if len(edges) else edges
    if len(lengths) == 0:
        return np.empty(0, np.int64), 0.0
    border, places = np.unique(edges, return_inverse=True)
    limit = min(NEAR * point_sets.bounding_box_diagonal(rest), NEAR_EDGES * harmless(lengths))
    points, place = rest[border].astype(np.float64), first_of_place(rest[border], limit)
    reach, is_seam = np.zeros(len(border)), np.zeros(len(border), bool)
    np.maximum.at(reach, place, np.linalg.norm(points - points[place], axis=1))
    ends = np.sort(place[places.reshape(-1, 2)], axis=1)
    _, index, uses = np.unique(ends @ np.array([len(rest), 1]), return_inverse=True, return_counts=True)
    is_seam[ends[(uses[index.ravel()] > 1) & (ends[:, 0] != ends[:, 1])]] = True  # as tips of hair that meet are not
    is_seam &= reach > rounding(rest)
    vertices, widest = border[is_seam[place]], reach[is_seam].max(initial=0.0)
    is_sure = widest < SURE * limit or 2 * len(vertices) > len(border)
    if len(vertices) == 0 or (surely and not is_sure):
        return vertices[:0], 0.0
    figure = 10.0 ** np.floor(np.log10(widest))
    return vertices, float(f"{np.ceil(widest / figure) * figure:.1g}")


def spread(weights, first):
    """n float: the highest of the weights of all copies (`first`, of copies())."""
    if first is None:
        return weights
    found = weights.copy()
    np.maximum.at(found, first, weights)
    return found[first]
