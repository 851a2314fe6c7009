# SPDX-License-Identifier: GPL-3.0-or-later
"""What of a mesh goes to the solver: it with near vertices merged, and with its mirror images.

The solver gets the *solver mesh*: copies of a vertex are one, and the images that planes make of it are attached where
they touch, with a target for each image of an anchor. Of what it gives back, each vertex takes the mean of what its
images did, turned back: so the result is as symmetric as the rest shape to the last bit, what lies in a plane stays in
it, and copies of a vertex stay as far apart as they are at rest. The latter holds as long as the region has all copies
or none: welding.spread() sees to it.

A plane that only *repeats* the mesh (Symmetric) joins every image to a vertex that is there, so that nothing is added;
one that *doubles* it (a Mirror modifier) joins those of the seam to themselves, and the others are new.
"""

from dataclasses import replace
from functools import cached_property

import numpy as np

from ...scene.core.fixed_points import bounding_box_diagonal
from ...scene.core.mirror_planes import reflection
from . import connected, welding
from .agreed_motion import agreed

#: Of the mesh's size, and of how far the shape is from rest: shapes that are nearer to each other are one.
SAME_SHAPE, SAME_MOVE = 1e-3, 0.1


def of(bind_input):
    """The solver mesh of a BindInput."""
    first = welding.copies(bind_input.where_merged, bind_input.merge_distance)
    is_plain = first is None and bind_input.planes is None
    return PlainMesh(bind_input) if is_plain else SolverMesh(bind_input, first)


def _turned(vectors, matrix):
    """... x 3. Most planes are those of the axes, which costs a tenth."""
    signs = np.diagonal(matrix)
    return vectors * signs if np.array_equal(matrix, np.diag(signs)) else vectors @ matrix.T


class PlainMesh:
    """The solver mesh of a mesh without planes and copies: itself."""

    def __init__(self, bind_input):
        self._of = bind_input
        self.roi, self.anchors = bind_input.roi, bind_input.anchors
        self.handles, self.strengths = bind_input.handles, bind_input.strengths
        self.border, self.border_strengths = bind_input.border, bind_input.border_strengths

    rest = property(lambda self: self._of.rest.astype(np.float64))
    held_rest = property(lambda self: self._of.rest[self._of.is_held])
    places = property(lambda self: np.arange(len(self._of.rest)))

    def _as_it_is(self, values):
        return values

    @staticmethod
    def examples(shapes):
        """[(n x 3 float64, number of the shape)] of n x 3 shapes."""
        return [(shape, number) for number, shape in enumerate(shapes)]

    triangles = without_images = targets = met = weights = start = cut_back = cut_back_rows = _as_it_is


class SolverMesh:
    """N vertices and K anchors.

    rest       N x 3 float64, the seam in its planes
    roi        N bool: may move where all copies may
    anchors    K int32, ascending
    handles    K int32: images of a handle are handles of their own, but one with it if they share a vertex
    strengths  K float64 or None: as if all of it had been read
    border     vertex numbers of a soft border, and border_strengths, likewise

    Where handles hold the same vertex, by copies or by images, hard ones lead, then the one with the lower number.
    """

    def __init__(self, bind_input, first):
        """first: n int, the lowest numbered copy of each vertex; None if there are none."""
        self._of = bind_input
        count = len(bind_input.rest)
        self._merged = np.arange(count) if first is None else np.unique(first, return_inverse=True)[1]
        self._join()
        self.roi = (np.bincount(self._merged, ~bind_input.roi) == 0)[self._source]
        self._share = bind_input.roi.sum() / max(1, self.roi.sum())  # springs are for a count of what may move
        self._read_anchors()
        self._read_border()

    def _join(self):
        """_turns: C 3 x 3 matrices, the identity first; _images: C x n, which vertex each image is."""
        of, merged = self._of, self._merged
        counts = np.bincount(merged)
        rest = np.stack([np.bincount(merged, column) for column in of.rest.T.astype(np.float64)], axis=1)
        rest /= counts[:, None]
        planes = np.empty((0, 4)) if of.planes is None else of.planes
        twins = np.full((len(planes), len(counts)), -1, np.int32)
        for twin, own in zip(twins, of.twins if len(planes) else (), strict=True):
            np.maximum.at(twin, merged, np.where(own < 0, -1, merged[own]).astype(np.int32))
        doubles = (twins < 0).any(axis=1)
        for plane, twin in zip(planes[doubles], twins[doubles], strict=True):
            seam = twin >= 0
            rest[seam] -= np.outer(rest[seam] @ plane[:3] - plane[3], plane[:3])
        turns, shifts, images = [np.eye(3)], [np.zeros(3)], np.arange(len(counts))[None]
        self._counts_before = []  # of each plane: vertices of the solver mesh before it, and whether it adds any
        source, element = np.arange(len(counts)), np.zeros(len(counts), int)
        for plane, twin, is_double in zip(planes, twins, doubles, strict=True):
            self._counts_before.append((len(source), is_double))
            matrix, shift = reflection(plane)
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

    def _read_anchors(self):
        """_claims: which of C x k images of anchors have a say, vertex after vertex; _begins: where those of each
        begin."""
        of, images = self._of, self._images[:, self._of.anchors]
        self.anchors, places = np.unique(images, return_inverse=True)
        self.anchors, places = self.anchors.astype(np.int32), places.ravel()
        self._places = places.reshape(images.shape)[0]  # k: which of the K each is
        count = int(of.handles.max(initial=-1)) + 1
        owners = np.tile(of.handles, len(images))
        rank = owners + np.where(np.tile(of.hard_anchors, len(images)), 0, count)
        leading = np.full(len(self.anchors), 2 * count)
        np.minimum.at(leading, places, rank)
        claims = np.flatnonzero(rank == leading[places])
        self._claims = claims[np.argsort(places[claims], kind="stable")]
        self._begins = np.searchsorted(places[self._claims], np.arange(len(self.anchors)))
        self._claim_counts = np.diff(np.append(self._begins, len(claims)))
        leaders = self._claims[self._begins]
        labels = self._joined_handles(owners, count)
        self.handles = np.unique(labels[leaders], return_inverse=True)[1].astype(np.int32)
        self.strengths = None
        if of.strengths is not None:  # a handle's spring is shared out among the vertices that it has
            scale = np.bincount(of.handles)[owners[leaders]] / np.bincount(self.handles)[self.handles]
            self.strengths = np.tile(of.strengths, len(images))[leaders] * scale * self._share

    def _joined_handles(self, owners, count):
        """C k: of each image of an anchor the lowest of the images of handles, e * count + p, that are one with its."""
        labels = owners + count * np.repeat(np.arange(len(self._turns)), len(self._of.anchors))
        own, first = labels[self._claims], labels[self._claims[self._begins]]
        parts = connected.parts(np.stack([own, np.repeat(first, self._claim_counts)], axis=1), len(self._turns) * count)
        self._across = []  # (anchors, images that are one with it) of each handle that a plane goes through
        for handle in range(count):
            one = np.flatnonzero(parts[handle::count] == parts[handle])
            if len(one) > 1:
                self._across.append((np.flatnonzero(self._of.handles == handle), one))
        return parts[labels]

    def _read_border(self):
        """Springs of a soft border fall with the square of what is free, as in core.springs."""
        of, self.border, self.border_strengths = self._of, None, None
        if of.border is None:
            return
        images = self._images[:, of.border]
        border, first = np.unique(images, return_index=True)
        is_own = self.roi[border] & ~np.isin(border, self.anchors)  # a handle may hold a copy or the other side of it
        strengths = np.broadcast_to(of.border_strengths, images.shape).ravel()[first]
        self.border = border[is_own].astype(np.int32)
        self.border_strengths = strengths[is_own] * self._share**2

    @cached_property
    def held_rest(self):
        """Rest positions of all that holds the solver mesh in its place."""
        return self.rest[np.unique(self._images[:, self._of.is_held])]

    @property
    def places(self):
        """n int: which vertex of the solver mesh each is."""
        return self._images[0]

    def triangles(self, triangles):
        """m x 3 int32 of the mesh to M x 3 of the solver mesh, facing out. Without those that merging leaves no area;
        faces that lie in a seam are there once."""
        merged = self._merged[triangles]
        triangles = triangles[(merged != np.roll(merged, 1, axis=1)).all(axis=1)]
        found, is_new = [self._images[0][triangles]], [np.ones(len(triangles), bool)]
        for before, is_double in self._counts_before:
            for number in range(len(is_new)):
                image = self._images[len(is_new)][triangles]
                is_new.append(is_new[number] & is_double & (image >= before).any(axis=1))
                image = image[is_new[-1]]
                found.append(image[:, ::-1] if np.linalg.det(self._turns[len(is_new) - 1]) < 0.0 else image)
        return np.concatenate(found).astype(np.int32)

    def without_images(self, summary):
        """A BindSummary of the solver mesh with the counts of the mesh."""
        of = self._of
        return replace(summary, vertex_count=len(of.rest), anchor_count=len(of.anchors), free_count=int(of.free.sum()))

    def targets(self, positions):
        """... x k x 3 float64 of the anchors to ... x K x 3."""
        return self.rest[self.anchors] + self._moves(positions)

    def met(self, positions):
        """Where the anchors get to that ... x k x 3 `positions` ask for: both ... x k x 3 float64."""
        return self._of.anchor_rest + self._moves(positions)[..., self._places, :]

    def _moves(self, positions):
        """... x K x 3: from rest, the mean of what all images and copies of the leading handle ask for. Handles that a
        plane goes through ask for what is the same on both sides."""
        rest = self._of.anchor_rest
        asked = positions - rest
        for anchors, own in self._across:
            goals = agreed(rest[anchors], positions[..., anchors, :], self._turns[own], self._shifts[own])
            asked[..., anchors, :] = goals - rest[anchors]
        of_images = np.concatenate([_turned(asked, turn) for turn in self._turns], axis=-2)
        return np.add.reduceat(of_images[..., self._claims, :], self._begins, axis=-2) / self._claim_counts[:, None]

    def weights(self, weights):
        """... x k to ... x K float64; None for None."""
        if weights is None:
            return None
        claims = self._claims % len(self._of.anchors)
        return np.add.reduceat(weights[..., claims], self._begins, axis=-1) / self._claim_counts

    def start(self, positions):
        """n x 3 of the mesh to N x 3 float64 to begin from; None for None."""
        return None if positions is None else self._moved(positions, range(len(self._turns)))

    def _moved(self, positions, elements):
        """N x 3 float64: the mean of what some images of n x 3 positions say."""
        moves = np.concatenate([_turned(positions - self._of.rest, self._turns[element]) for element in elements])
        images = self._images[list(elements)].ravel()
        sums = np.stack([np.bincount(images, column) for column in moves.T], axis=1)
        return self.rest + sums / np.bincount(images)[:, None]

    def examples(self, shapes):
        """[(N x 3 float64, number of the shape)] of n x 3 shapes.

        One that is the same on both sides is made so to the last bit. Of the others, where planes repeat the mesh, the
        images count too, unless a shape is like them: what a left arm shows holds for the right one.
        """
        most = SAME_SHAPE * bounding_box_diagonal(self.rest)
        is_repeated = not any(is_double for _, is_double in self._counts_before)
        found, one_sided = [], []
        for number, shape in enumerate(shapes):
            on_both_sides = self.start(shape)
            own = self._moved(shape, [0]) if is_repeated else on_both_sides
            near = min(most, SAME_MOVE * np.abs(shape - self._of.rest).max(initial=0.0))
            is_symmetric = np.abs(own - on_both_sides).max(initial=0.0) <= near
            found.append((on_both_sides if is_symmetric else own, number))
            if not is_symmetric:
                one_sided.append((shape, number, near))
        for shape, number, near in one_sided:
            for element in range(1, len(self._turns)):
                image = self._moved(shape, [element])
                if all(np.abs(image - each).max(initial=0.0) > near for each, _ in found):
                    found.append((image, number))
        return found

    def cut_back(self, positions):
        """N x 3 of the solver mesh to the mesh's n x 3 float64, symmetric."""
        moved = positions - self.rest
        moves = moved.take(self._images[0], axis=0)
        for turn, image in zip(self._turns[1:], self._images[1:], strict=True):
            moves += _turned(moved.take(image, axis=0), turn.T)  # a reflection's transpose is what undoes it
        return self._of.rest + moves / len(self._turns)

    def cut_back_rows(self, rows):
        """r x N x 3 to r x n x 3 float32."""
        cut = np.empty((len(rows), *self._of.rest.shape), np.float32)
        for number, row in enumerate(rows):
            cut[number] = self.cut_back(row)
        return cut
