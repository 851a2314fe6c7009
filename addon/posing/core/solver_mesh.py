# SPDX-License-Identifier: GPL-3.0-or-later
"""What of a mesh goes to the solver: the whole of it (scene/core/whole_mesh.py), with targets for images of anchors.
Copies of a vertex stay together where the region has all of them or none, which welding.spread() sees to."""

import itertools
from functools import cached_property

import numpy as np

from ...scene.core import point_sets, whole_mesh
from ...scene.core.point_sets import bounding_box_diagonal

#: Of the mesh's size, and of how far the shape is from rest: shapes that are nearer to each other are one.
SAME_SHAPE, SAME_MOVE = 1e-3, 0.1


class SolverMesh(whole_mesh.WholeMesh):
    """N vertices and K anchors.

    roi        N bool: may move where all copies may
    anchors    K int32, ascending
    handles    K int32: images of a handle are handles of their own, but one with it if they share a vertex
    owners     K int32: number of the mesh's own handle that leads there
    stiffness  N float64 or None
    strengths  K float64 or None: of each spring, shared out (_share_out)
    border     vertex numbers of a soft border, and border_strengths, likewise

    Where handles hold the same vertex, by copies or by images, hard ones lead, then the one with the lower number.
    """

    def __init__(self, bind_input):
        self._of = bind_input
        super().__init__(bind_input.rest, bind_input.copies, bind_input.planes, bind_input.twins)
        if self.is_plain:
            for name in ("roi", "anchors", "handles", "stiffness", "strengths", "border", "border_strengths"):
                setattr(self, name, getattr(bind_input, name))
            self.owners = self.handles
            self._share_out()
            return
        self.roi = (np.bincount(self._merged, ~bind_input.roi) == 0)[self._source]
        self.stiffness, images = bind_input.stiffness, self._images.ravel()
        if self.stiffness is not None:  # the mean of all that a vertex is the image of
            self.stiffness = np.bincount(images, np.tile(self.stiffness, len(self._images))) / np.bincount(images)
        self._read_anchors()
        self._read_border()
        self._share_out()

    def _share_out(self):
        """Springs are the weaker the more vertices may move that hang together with them: of a handle by their count,
        and of a soft border by its square. So what moves elsewhere does not matter."""
        if self.strengths is None and self.border is None:
            return
        corners, edges = self._of.face_corners, []
        following = whole_mesh.edge_ends(corners, self._of.face_starts)
        for images in self._images.astype(np.int32):
            moves = self.roi[images]
            inside = np.flatnonzero(moves[corners] & moves[following])  # a small part of a large mesh
            edges.append(np.stack([images[corners[inside]], images[following[inside]]], axis=1))
        parts = point_sets.parts(np.concatenate(edges), len(self.roi))
        counts = np.bincount(parts, self.roi)[parts]
        if self.strengths is not None:
            self.strengths = self.strengths / np.maximum(counts[self.anchors], 1.0)
        if self.border is not None:
            self.border_strengths = self.border_strengths / counts[self.border] ** 2

    def _read_anchors(self):
        """_claims: which of C x k images of anchors have a say, by vertices; _begins: where those of each begin."""
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
        labels = owners + count * np.repeat(np.arange(len(self._turns)), len(self._of.anchors))
        own, first = labels[self._claims], labels[self._claims[self._begins]]
        joined = np.stack([own, np.repeat(first, self._claim_counts)], axis=1)
        parts = point_sets.parts(joined, len(self._turns) * count)
        labels = parts[labels]
        self.handles = np.unique(labels[leaders], return_inverse=True)[1].astype(np.int32)
        self.owners = owners[leaders]
        self.strengths = None
        if of.strengths is not None:  # a handle's spring is shared out among the vertices that it has
            scale = np.bincount(of.handles)[owners[leaders]] / np.bincount(self.handles)[self.handles]
            self.strengths = np.tile(of.strengths, len(images))[leaders] * scale

    def _read_border(self):
        of, self.border, self.border_strengths = self._of, None, None
        if of.border is None:
            return
        images = self._images[:, of.border]
        border, first = np.unique(images, return_index=True)
        is_own = self.roi[border] & ~np.isin(border, self.anchors)  # a handle may hold a copy or the other side of it
        strengths = np.broadcast_to(of.border_strengths, images.shape).ravel()[first]
        self.border = border[is_own].astype(np.int32)
        self.border_strengths = strengths[is_own]

    @cached_property
    def held_rest(self):
        """Rest positions of all that holds the solver mesh in its place."""
        held = self._of.is_held
        return self.rest.take(np.flatnonzero(held) if self.is_plain else np.unique(self._images[:, held]), axis=0)

    def targets(self, positions):
        """... x k x 3 float64 of the anchors to ... x K x 3."""
        return positions if self.is_plain else self.rest[self.anchors] + self._moves(positions)

    def met(self, positions):
        """Where the anchors get to that ... x k x 3 `positions` ask for: both ... x k x 3 float64."""
        return positions if self.is_plain else self._of.anchor_rest + self._moves(positions)[..., self._places, :]

    def _moves(self, positions):
        """... x K x 3: from rest, the mean of what all images and copies of the leading handle ask for."""
        asked = positions - self._of.anchor_rest
        of_images = np.concatenate([asked @ turn.T for turn in self._turns], axis=-2)
        return np.add.reduceat(of_images[..., self._claims, :], self._begins, axis=-2) / self._claim_counts[:, None]

    def weights(self, weights):
        """... x k to ... x K float64; None for None."""
        if weights is None or self.is_plain:
            return weights
        claims = self._claims % len(self._of.anchors)
        return np.add.reduceat(weights[..., claims], self._begins, axis=-1) / self._claim_counts

    def examples(self, shapes):
        """[(N x 3 float64, number of the shape)] of n x 3 shapes. Where planes repeat the mesh, their images are behind
        them, unless a shape is like these: what a left arm shows holds for the right one."""
        numbered = list(enumerate(shapes))
        if self.is_plain or any(is_double for _, is_double in self._counts_before):
            return [(self.start(shape), number) for number, shape in numbered]
        found = [(self._moved(shape, [0]), number) for number, shape in numbered]
        most = SAME_SHAPE * bounding_box_diagonal(self.rest)
        for (number, shape), element in itertools.product(numbered, range(1, len(self._turns))):
            image, near = self._moved(shape, [element]), min(most, SAME_MOVE * np.abs(shape - self._of.rest).max())
            if all(np.abs(image - each).max() > near for each, _ in found):
                found.append((image, number))
        return found
