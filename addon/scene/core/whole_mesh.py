# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh as a whole: with copies of a vertex merged, and with its mirror images.

Copies are one vertex, and the images that planes make of the mesh are attached where they touch. Of shapes of the
whole, each vertex takes the mean of what its images did, turned back: so the result is as symmetric as the rest shape
to the last bit, what lies in a plane stays in it, and copies of a vertex stay as far apart as they are at rest.

A plane that only *repeats* the mesh (Symmetric) joins every image to a vertex that is there, so that nothing is added;
one that *doubles* it (a Mirror modifier) joins those of the seam to themselves, and the others are new. A plane: unit
normal, distance from the origin along it.
"""

import numpy as np

from ...solver import native_loader
from . import motion, point_sets


class WholeMesh:
    """N vertices, of n of the mesh.

    rest      N x 3 float64, the seam in its planes
    places    n int: which of the N each vertex is
    is_plain  no copies, no planes: the mesh is the whole itself, and all stays as it is, to the bit; `rest` is float32
    """

    def __init__(self, rest, copies=None, planes=None, twins=None):
        """The whole of n x 3 float32 `rest`; copies: as of scene/kept.py; planes, twins: as of mirrors.seams()."""
        self._own_rest = rest
        self.is_plain = copies is None and planes is None
        if self.is_plain:
            self.rest, self._images = rest, np.arange(len(rest))[None]
            return
        self._firsts, self._merged = np.arange(len(rest)), np.arange(len(rest))
        if copies is not None:
            self._firsts, self._merged = np.unique(copies, return_inverse=True)
        self._join(np.empty((0, 4)) if planes is None else planes, () if planes is None else twins)

    def _join(self, planes, own_twins):
        """_turns: C 3 x 3 matrices, the identity first; _images: C x n, which vertex each image is."""
        merged, counts = self._merged, np.bincount(self._merged)
        rest = np.stack([np.bincount(merged, column) for column in self._own_rest.T.astype(np.float64)], axis=1)
        rest /= counts[:, None]
        twins = np.full((len(planes), len(counts)), -1, np.int32)
        for twin, own in zip(twins, own_twins, strict=True):
            np.maximum.at(twin, merged, np.where(own < 0, -1, merged[own]).astype(np.int32))
        doubles = (twins < 0).any(axis=1)
        for plane, twin in zip(planes[doubles], twins[doubles], strict=True):
            seam = twin >= 0
            rest[seam] -= np.outer(rest[seam] @ plane[:3] - plane[3], plane[:3])
        turns, shifts, images = [np.eye(3)], [np.zeros(3)], np.arange(len(counts))[None]
        self._counts_before = []  # of each plane: vertices of the whole before it, and whether it adds any
        source, element = np.arange(len(counts)), np.zeros(len(counts), int)
        for plane, twin, is_double in zip(planes, twins, doubles, strict=True):
            self._counts_before.append((len(source), is_double))
            matrix, shift = motion.reflection(plane)
            is_joined = twin[source] >= 0
            image = np.empty(len(source), np.int64)
            image[is_joined] = images[element[is_joined], twin[source[is_joined]]]
            image[~is_joined] = len(source) + np.arange(np.count_nonzero(~is_joined))
            source = np.concatenate([source, source[~is_joined]])
            element = np.concatenate([element, element[~is_joined] + len(turns)])
            images = np.concatenate([images, image[images]])
            shifts += [matrix @ each + shift for each in shifts]
            turns += [matrix @ each for each in turns]
        self._turns, self._shifts, self._source = np.array(turns), np.array(shifts), source
        self._images = images if len(counts) == len(merged) else images[:, merged]
        self.rest = np.einsum("nij,nj->ni", self._turns[element], rest[source]) + self._shifts[element]

    @property
    def places(self):
        """n int: which vertex of the whole each is."""
        return self._images[0]

    def triangles(self, triangles):
        """m x 3 int32 of the mesh to M x 3 of the whole, facing out. Without those that merging leaves no area; faces
        that lie in a seam are there once. Copies are last: of faces in one place the core reads the first."""
        if self.is_plain:
            return triangles
        merged = self._merged[triangles]
        triangles = triangles[(merged != np.roll(merged, 1, axis=1)).all(axis=1)]
        is_copy = self._firsts[self._merged] != np.arange(len(self._merged))
        triangles = triangles[np.argsort(is_copy[triangles].all(axis=1), kind="stable")]
        found, is_new = [self._images[0][triangles]], [np.ones(len(triangles), bool)]
        for before, is_double in self._counts_before:
            for number in range(len(is_new)):
                image = self._images[len(is_new)][triangles]
                is_new.append(is_new[number] & is_double & (image >= before).any(axis=1))
                image = image[is_new[-1]]
                found.append(image[:, ::-1] if np.linalg.det(self._turns[len(is_new) - 1]) < 0.0 else image)
        return np.concatenate(found).astype(np.int32)

    def values(self, values):
        """... x n of the mesh to ... x N: each has that of the lowest numbered vertex that it is an image of."""
        return values if self.is_plain else np.ascontiguousarray(values[..., self._firsts[self._source]])

    def pairs(self, vertices, points):
        """(vertices of the whole, points) of k vertices and k x 3 points: with images where these are other ones."""
        if self.is_plain:
            return vertices, points
        found, places = self.places[vertices], [points]
        for turn, shift, images in zip(self._turns[1:], self._shifts[1:], self._images[1:], strict=True):
            is_new = ~np.isin(images[vertices], found)
            found = np.append(found, images[vertices][is_new])
            places.append(points[is_new] @ turn.T + shift)
        return found, np.concatenate(places)

    def start(self, positions):
        """n x 3 positions of the mesh to N x 3 float64; None for None."""
        return positions if positions is None or self.is_plain else self._moved(positions, range(len(self._turns)))

    def _moved(self, positions, elements):
        """N x 3 float64: the mean of what some images of n x 3 positions say."""
        moves = np.concatenate([(positions - self._own_rest) @ self._turns[element].T for element in elements])
        images = self._images[list(elements)].ravel()
        sums = np.stack([np.bincount(images, column) for column in moves.T], axis=1)
        return self.rest + sums / np.bincount(images)[:, None]

    def cut_back(self, positions):
        """N x 3 of the whole to the mesh's n x 3 float64, symmetric."""
        if self.is_plain:
            return positions
        moved = positions - self.rest
        moves = moved.take(self._images[0], axis=0)
        for turn, image in zip(self._turns[1:], self._images[1:], strict=True):
            moves += moved.take(image, axis=0) @ turn  # a reflection's transpose is what undoes it
        return self._own_rest + moves / len(self._turns)

    def cut_back_rows(self, rows):
        """r x N x 3 to r x n x 3 float32."""
        if self.is_plain:
            return rows
        cut = np.empty((len(rows), *self._own_rest.shape), np.float32)
        for number, row in enumerate(rows):
            cut[number] = self.cut_back(row)
        return cut


def edge_ends(face_corners, face_starts):
    """Where the edge from each face corner goes to: the next corner of its face."""
    following = np.append(face_corners[1:], face_corners[:1])
    following[np.append(face_starts[1:], len(face_corners)) - 1] = face_corners[face_starts]
    return following


def is_a_border(seam, face_corners, face_starts):
    """Whether the mesh ends at the vertices of n bool `seam`: a half does. One that goes on beyond the plane, or does
    not reach it, has nothing to be joined to there."""
    if not seam.any():
        return False
    inside = np.count_nonzero(seam[face_corners] & seam[edge_ends(face_corners, face_starts)])
    borders = native_loader.module().border_edges(len(seam), face_corners, face_starts)
    # At least half of the edges: one that is no border is there twice. Or single vertices touch the plane.
    return bool(3 * np.count_nonzero(seam[borders].all(axis=1)) >= inside)


def needed(planes, twins, roi, anchors):
    """(planes, twins) of a BindInput without the planes whose seam nothing moves; (None, None) for none."""
    if planes is None:
        return None, None
    moves = roi.copy()
    moves[anchors] = True
    is_needed = [bool(moves[twin >= 0].any()) for twin in twins]
    return (planes[is_needed], twins[is_needed]) if any(is_needed) else (None, None)


#: A vertex is the mirror image of another if it is no farther from it than this share of the mesh's size. Nearly all
#: meshes are symmetric to rounding, so the first pairs most vertices, and few are left for the wider search.
TOLERANCES = (1e-6, 1e-3)

#: So far vertices are drawn to the middle of the faces around them, which tells those at one place apart.
TOWARDS = 0.25


def partners(rest, face_corners, face_starts, plane):
    """n int32: the mirror image of each vertex, itself for one in the plane, -1 where there is none.

    The arrays are those of a BindInput; plane: unit normal and distance. Each is its twin's twin. Among vertices at one
    place (split edges) the faces around decide.
    """
    points = rest.astype(np.float64)
    size = point_sets.bounding_box_diagonal(points)
    drawn = points + TOWARDS * (_middles_around(points, face_corners, face_starts) - points)
    matrix, shift = motion.reflection(plane)
    images, drawn_images = (each @ matrix.T + shift for each in (points, drawn))
    twins = np.full(len(points), -1, np.int32)
    for tolerance in TOLERANCES if size > 0.0 else ():
        left = np.flatnonzero(twins < 0)
        numbers = np.arange(len(left), dtype=np.int32)
        tree = native_loader.module().Surface(drawn[left], np.repeat(numbers[:, None], 3, axis=1))
        nearest = tree.nearest(drawn_images[left])[0]
        apart = np.linalg.norm(images[left] - points[left[nearest]], axis=1)
        is_mutual = (nearest >= 0) & (apart <= tolerance * size) & (nearest[nearest] == numbers)
        twins[left[is_mutual]] = left[nearest[is_mutual]]
    return twins


def _middles_around(points, corners, starts):
    """n x 3: the mean of the middles of the faces around each vertex; the vertex itself where there are none."""
    if len(starts) == 0:
        return points.copy()
    sizes = np.diff(np.append(starts, len(corners)))
    faces = np.repeat(np.arange(len(starts)), sizes)
    centres = np.stack([np.bincount(faces, points[corners, axis]) for axis in range(3)], axis=1) / sizes[:, None]
    counts = np.bincount(corners, minlength=len(points))
    sums = [np.bincount(corners, centres[faces, axis], len(points)) for axis in range(3)]
    return np.where(counts[:, None] > 0, np.stack(sums, axis=1) / np.maximum(counts, 1)[:, None], points)
