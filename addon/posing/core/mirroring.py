# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that are one part of a mirrored surface, or the same on both sides of a plane.

The solver gets the *solver mesh*: the mesh and its images, joined where they touch, with a target for each image of an
anchor. Of what it gives back, each vertex takes the mean of what its images did, turned back: so the result is as
symmetric as the rest shape to the last bit, and what lies in a plane stays in it.

A plane that only *repeats* the mesh (Symmetric) joins every image to a vertex that is there, so that nothing is added;
one that *doubles* it (a Mirror modifier) joins those of the seam to themselves, and the others are new.
"""

from dataclasses import replace
from functools import cached_property

import numpy as np

from ...scene.core import fixed_points
from ...scene.core.mirror_planes import reflection
from .agreed_motion import agreed
from .cut_back import Cut


def of(bind_input):
    """What of `bind_input` (a BindInput) goes to the solver, and back: a PlainMesh or a MirroredMesh."""
    return PlainMesh(bind_input) if bind_input.planes is None else MirroredMesh(bind_input)


def _turned(vectors, matrix):
    """... x 3. Most planes are those of the axes, which costs a tenth."""
    signs = np.diagonal(matrix)
    return vectors * signs if np.array_equal(matrix, np.diag(signs)) else vectors @ matrix.T


class PlainMesh:
    """The solver mesh of a mesh without planes: itself."""

    def __init__(self, bind_input):
        self._of = bind_input
        self.roi, self.anchors = bind_input.roi, bind_input.anchors
        self.handles, self.strengths = bind_input.handles, bind_input.strengths
        self.border, self.border_strengths = bind_input.border, bind_input.border_strengths

    @property
    def rest(self):
        return self._of.rest.astype(np.float64)

    @property
    def held_rest(self):
        return self._of.rest[self._of.is_held]

    @property
    def diagonal(self):
        return self._of.diagonal

    def triangles(self, triangles):
        return triangles

    @property
    def places(self):
        """n int: which vertex of the solver mesh each is."""
        return np.arange(len(self._of.rest))

    def without_images(self, summary):
        return summary

    def targets(self, positions):
        return positions

    def weights(self, weights):
        return weights

    def start(self, positions):
        return positions

    def cut_back(self, positions):
        return positions

    def cut_back_rows(self, rows):
        return rows

    def met(self, positions):
        return positions

    def merged(self, positions):
        return positions


class MirroredMesh:
    """The solver mesh, N vertices of which the first n are those of the mesh, and K anchors.

    rest       N x 3 float64, the seam in its planes
    roi        N bool
    anchors    K int32, ascending
    handles    K int32: images of a handle are handles of their own, but one with it if they share a vertex
    strengths  K float64 or None: as if all of it had been read
    border     vertex numbers of a soft border, and border_strengths, likewise

    Where images of two handles hold the same vertex, the handle with the lower number leads there.
    """

    def __init__(self, bind_input):
        self._of = bind_input
        self._join(bind_input.planes, bind_input.twins)
        self.roi = bind_input.roi[self._source]
        self._read_anchors()
        self._read_border()

    def _join(self, planes, twins):
        """_turns: C 3 x 3 matrices, the identity first; _images: C x n, which vertex each image is."""
        count = len(self._of.rest)
        doubles = (twins < 0).any(axis=1)
        rest = self._of.rest.astype(np.float64)
        for plane, twin in zip(planes[doubles], twins[doubles], strict=True):
            seam = twin >= 0
            rest[seam] -= np.outer(rest[seam] @ plane[:3] - plane[3], plane[:3])
        turns, shifts, images = [np.eye(3)], [np.zeros(3)], np.arange(count)[None]
        self._counts_before = []  # of each plane: vertices of the solver mesh before it, and whether it adds any
        source, element = np.arange(count), np.zeros(count, int)
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
        self._turns, self._shifts, self._images, self._source = np.array(turns), np.array(shifts), images, source
        turned = np.einsum("nij,nj->ni", self._turns[element], rest[source])
        self.rest = turned + self._shifts[element]

    def _read_anchors(self):
        bind_input, images = self._of, self._images[:, self._of.anchors]
        self.anchors = np.unique(images).astype(np.int32)
        self._places = np.searchsorted(self.anchors, images)  # C x k: which of the K each image is
        self._leaders = np.full(len(self.anchors), np.iinfo(np.int32).max, np.int32)
        np.minimum.at(self._leaders, self._places, np.broadcast_to(bind_input.handles, self._places.shape))
        self._claims = [np.flatnonzero(bind_input.handles == self._leaders[places]) for places in self._places]
        self._claim_counts = self._mean_counts()
        self.handles = self._joined_handles()
        self.strengths = self._shared_strengths()

    def _mean_counts(self):
        counts = np.zeros(len(self.anchors), int)
        for places, claims in zip(self._places, self._claims, strict=True):
            counts[places[claims]] += 1
        return counts

    def _joined_handles(self):
        bind_input = self._of
        count = int(bind_input.handles.max(initial=-1)) + 1
        labels = np.arange(len(self._turns) * count)  # of image e of handle p at e * count + p
        while True:
            lowest = np.full(len(self.anchors), len(labels))
            for number, (places, claims) in enumerate(zip(self._places, self._claims, strict=True)):
                np.minimum.at(lowest, places[claims], labels[number * count + bind_input.handles[claims]])
            before = labels.copy()
            for number, (places, claims) in enumerate(zip(self._places, self._claims, strict=True)):
                np.minimum.at(labels, number * count + bind_input.handles[claims], lowest[places[claims]])
            if np.array_equal(labels, before):
                break
        self._across = []  # (anchors, images that are one with it) of each handle that a plane goes through
        for handle in range(count):
            own = np.flatnonzero(labels[handle::count] == labels[handle])
            if len(own) > 1:
                self._across.append((np.flatnonzero(bind_input.handles == handle), own))
        return np.unique(lowest, return_inverse=True)[1].astype(np.int32)

    def _read_border(self):
        """Springs of a soft border fall with the square of what is free, as in core.springs."""
        bind_input, self.border, self.border_strengths = self._of, None, None
        if bind_input.border is None:
            return
        images = self._images[:, bind_input.border]
        border, first = np.unique(images, return_index=True)
        is_own = ~np.isin(border, self.anchors)  # with Symmetric a handle may hold the other side of it
        strengths = np.broadcast_to(bind_input.border_strengths, images.shape).ravel()[first]
        self.border = border[is_own].astype(np.int32)
        self.border_strengths = strengths[is_own] * (bind_input.roi.sum() / max(1, self.roi.sum())) ** 2

    def _shared_strengths(self):
        """A handle's spring is shared out among the vertices that it has in the solver mesh, as core.springs does."""
        bind_input = self._of
        if bind_input.strengths is None:
            return None
        sizes = np.bincount(bind_input.handles)
        solver_sizes = np.bincount(self.handles)
        strengths = np.empty(len(self.anchors))
        for places, claims in zip(self._places, self._claims, strict=True):
            strengths[places[claims]] = bind_input.strengths[claims]
        scale = sizes[self._leaders] / solver_sizes[self.handles]
        return strengths * scale * (bind_input.roi.sum() / max(1, self.roi.sum()))

    @cached_property
    def held_rest(self):
        """Rest positions of all that holds the solver mesh in its place."""
        held = np.zeros(len(self.rest), bool)
        for image in self._images:
            held[image[self._of.is_held]] = True
        return self.rest[held]

    @property
    def places(self):
        """n int: which vertex of the solver mesh each is."""
        return self._images[0]

    @cached_property
    def diagonal(self):
        return fixed_points.bounding_box_diagonal(self.rest)

    def triangles(self, triangles):
        """m x 3 int32 of the mesh to M x 3 of the solver mesh, facing out. Faces that lie in a seam are there once."""
        found, is_new = [triangles], [np.ones(len(triangles), bool)]
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
        return self._of.anchor_rest + self._moves(positions)[..., self._places[0], :]

    def merged(self, positions):
        """Where merging alone has the anchors go, of core.welding."""
        return positions

    def _moves(self, positions):
        """... x K x 3: from rest, the mean of what all images of the leading handle ask for. Handles that a plane goes
        through ask for what is the same on both sides."""
        rest = self._of.anchor_rest
        asked = positions - rest
        for anchors, own in self._across:
            goals = agreed(rest[anchors], positions[..., anchors, :], self._turns[own], self._shifts[own])
            asked[..., anchors, :] = goals - rest[anchors]
        moves = np.zeros((*asked.shape[:-2], len(self.anchors), 3))
        for turn, places, claims in zip(self._turns, self._places, self._claims, strict=True):
            moves[..., places[claims], :] += _turned(asked[..., claims, :], turn)
        return moves / self._claim_counts[:, None]

    def weights(self, weights):
        """... x k to ... x K float64; None for None."""
        if weights is None:
            return None
        means = np.zeros((*weights.shape[:-1], len(self.anchors)))
        for places, claims in zip(self._places, self._claims, strict=True):
            means[..., places[claims]] += weights[..., claims]
        return means / self._claim_counts

    def start(self, positions):
        """n x 3 of the mesh to N x 3 float64 to begin from; what cut_back() gave is that of which it was cut."""
        if positions is None:
            return None
        solved = getattr(positions, "solved", None)
        if solved is not None:
            return solved
        moves, counts = np.zeros(self.rest.shape), np.zeros((len(self.rest), 1))
        for turn, image in zip(self._turns, self._images, strict=True):
            moves[image] += _turned(positions - self._of.rest, turn)
            counts[image] += 1.0
        return self.rest + moves / counts

    def cut_back(self, positions):
        """N x 3 of the solver mesh to the mesh's n x 3 float64, symmetric."""
        moved = positions - self.rest
        moves = moved[: len(self._of.rest)].copy()  # of the mesh itself, which is the first image
        for turn, image in zip(self._turns[1:], self._images[1:], strict=True):
            moves += _turned(moved.take(image, axis=0), turn.T)  # a reflection's transpose is what undoes it
        return Cut.of(self._of.rest + moves / len(self._turns), positions)

    def cut_back_rows(self, rows):
        """r x N x 3 to r x n x 3 float32."""
        cut = np.empty((len(rows), *self._of.rest.shape), np.float32)
        for number, row in enumerate(rows):
            cut[number] = self.cut_back(row)
        return cut
