# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertices within a distance are one to the solver: open seams and doubles, without a change of the artist's mesh.

As for mirrored meshes (core.mirroring) the solver gets a *solver mesh*; all copies of a vertex of it take what that was
moved by, so they stay as far apart as they are at rest. That holds as long as the region has all copies or
none: spread() sees to it.
"""

from dataclasses import replace

import numpy as np

from . import mirroring
from .coincidence import first_of_place
from .cut_back import Cut

#: Of the faces' edges: where merging takes more of them away, it merges what is no seam.
MOST_COLLAPSED = 0.02


def copies(rest, merge_distance):
    """n int, not to be written to: of n x 3 float32 `rest` the lowest numbered copy of each vertex; None if there is
    nothing to merge."""
    if merge_distance <= 0.0:
        return None
    first = first_of_place(rest, merge_distance)
    return None if np.array_equal(first, np.arange(len(first))) else first


def collapsed_share(rest, face_corners, face_starts, merge_distance):
    """Share, 0 to 1, of the faces' edges with ends apart that merging takes the length of."""
    first = copies(rest, merge_distance)
    if first is None or len(face_corners) == 0:
        return 0.0
    ends = _edge_ends(face_corners, face_starts)
    gone = np.flatnonzero(first[face_corners] == first[ends])  # all without length are among them
    had_length = np.count_nonzero((rest[face_corners[gone]] != rest[ends[gone]]).any(axis=1))
    return had_length / max(1, len(ends) - len(gone) + had_length)


def harmless_distance(rest, face_corners, face_starts, merge_distance):
    """A shorter merge distance, rounded down to one figure, that takes no more edges away than MOST_COLLAPSED."""
    ends = _edge_ends(face_corners, face_starts)
    lengths = np.linalg.norm(rest[face_corners].astype(np.float64) - rest[ends], axis=1)
    distance = min(merge_distance, float(np.quantile(lengths[lengths > 0.0], MOST_COLLAPSED)))
    while True:
        distance *= 0.5
        figure = 10.0 ** np.floor(np.log10(distance))
        rounded = float(f"{np.floor(distance / figure) * figure:.1g}")
        if collapsed_share(rest, face_corners, face_starts, rounded) <= MOST_COLLAPSED:
            return rounded


def _edge_ends(corners, starts):
    """Where the edge from each face corner goes to: the next corner of its face."""
    ends = np.append(corners[1:], corners[:1])
    ends[np.append(starts[1:], len(corners)) - 1] = corners[starts]
    return ends


def spread(weights, first, lowest=False):
    """n float: the highest of the weights of all copies (`first`, of copies()), or the lowest."""
    if first is None:
        return weights
    found = weights.copy()
    (np.minimum if lowest else np.maximum).at(found, first, weights)
    return found[first]


def of(bind_input):
    """What of `bind_input` (a BindInput) goes to the solver, and back: a Welded where vertices are to be merged, else
    what mirroring.of() makes of it."""
    first = copies(bind_input.rest, bind_input.merge_distance)
    return mirroring.of(bind_input) if first is None else WeldedMesh(bind_input, first)


class WeldedMesh:
    """The solver mesh of a mesh with its copies merged, see mirroring.MirroredMesh for what it consists of.

    Where several copies of a vertex are anchors, hard ones lead, then those of the handle with the lower number. A
    vertex of the solver mesh may move where all of its copies may.
    """

    def __init__(self, bind_input, first):
        """first: n int, the lowest numbered copy of each vertex."""
        self._of = bind_input
        self._kept, self._merged = np.unique(first, return_inverse=True)
        self._counts = np.bincount(self._merged)
        self._inner_input = self._merge()
        self._inner = mirroring.of(self._inner_input)

    def _mean(self, values):
        """n x 3 to r x 3 float64: the mean of all copies."""
        return (
            np.stack([np.bincount(self._merged, column) for column in values.T.astype(np.float64)], axis=1)
            / (self._counts[:, None])
        )

    def _merge(self):
        of, count = self._of, len(self._kept)
        roi = np.bincount(self._merged, ~of.roi) == 0
        anchors, self._places = np.unique(self._merged[of.anchors], return_inverse=True)
        handles = self._choose_leaders(len(anchors))
        share = of.roi.sum() / max(1, roi.sum())  # springs are for a count of what may move, see core.springs
        border, border_strengths = self._merged_border(roi, anchors, share)
        twins = of.twins
        if twins is not None:
            twins = np.full((len(of.twins), count), -1, np.int32)
            for merged, own in zip(twins, of.twins, strict=True):
                np.maximum.at(merged, self._merged, np.where(own < 0, -1, self._merged[own]).astype(np.int32))
        return replace(
            of,
            rest=self._mean(of.rest).astype(np.float32),
            face_corners=self._merged[of.face_corners].astype(np.int32),
            anchors=anchors.astype(np.int32),
            roi=roi,
            handles=handles,
            strengths=self._merged_strengths(handles, share),
            border=border,
            border_strengths=border_strengths,
            twins=twins,
            merge_distance=0.0,
        )

    def _choose_leaders(self, count):
        """_claims: which anchors have a say, in the order of the merged ones, and where those of each begin."""
        of = self._of
        rank = of.handles + np.where(of.hard_anchors, 0, int(of.handles.max(initial=0)) + 1)
        leading = np.full(count, np.iinfo(rank.dtype).max, rank.dtype)
        np.minimum.at(leading, self._places, rank)
        claims = np.flatnonzero(rank == leading[self._places])
        self._claims = claims[np.argsort(self._places[claims], kind="stable")]
        self._begins = np.searchsorted(self._places[self._claims], np.arange(count))
        return of.handles[self._claims[self._begins]].astype(np.int32)

    def _merged_strengths(self, handles, share):
        """A handle's spring is shared out among the vertices that it still has."""
        of = self._of
        if of.strengths is None:
            return None
        counts = np.bincount(of.handles) / np.maximum(1, np.bincount(handles, minlength=int(of.handles.max()) + 1))
        return of.strengths[self._claims[self._begins]] * (counts[handles] * share)

    def _merged_border(self, roi, anchors, share):
        of = self._of
        if of.border is None:
            return None, None
        border, first = np.unique(self._merged[of.border], return_index=True)
        is_own = roi[border] & ~np.isin(border, anchors)
        return border[is_own].astype(np.int32), of.border_strengths[first][is_own] * share**2

    roi = property(lambda self: self._inner.roi)
    anchors = property(lambda self: self._inner.anchors)
    handles = property(lambda self: self._inner.handles)
    strengths = property(lambda self: self._inner.strengths)
    border = property(lambda self: self._inner.border)
    border_strengths = property(lambda self: self._inner.border_strengths)
    rest = property(lambda self: self._inner.rest)
    held_rest = property(lambda self: self._inner.held_rest)
    diagonal = property(lambda self: self._inner.diagonal)

    @property
    def places(self):
        """n int: which vertex of the solver mesh each is."""
        return self._inner.places[self._merged]

    def triangles(self, triangles):
        """Without those that merging leaves no area."""
        merged = self._merged[triangles].astype(np.int32)
        turned = np.roll(merged, 1, axis=1)
        return self._inner.triangles(np.ascontiguousarray(merged[(merged != turned).all(axis=1)]))

    def without_images(self, summary):
        of = self._of
        return replace(summary, vertex_count=len(of.rest), anchor_count=len(of.anchors), free_count=int(of.free.sum()))

    def _asked(self, positions):
        """... x k x 3 to where the merged anchors are to go: moved by the mean of what those that lead ask for."""
        moves = (positions - self._of.anchor_rest)[..., self._claims, :]
        return self._inner_input.anchor_rest + self._mean_of_claims(moves, axis=-2)

    def _mean_of_claims(self, values, axis):
        sums = np.add.reduceat(values, self._begins, axis=axis)
        counts = np.diff(np.append(self._begins, len(self._claims)))
        return sums / (counts[:, None] if axis == -2 else counts)

    def targets(self, positions):
        return self._inner.targets(self._asked(positions))

    def met(self, positions):
        return self._of_anchors(self._inner.met(self._asked(positions)))

    def merged(self, positions):
        return self._of_anchors(self._asked(positions))

    def _of_anchors(self, merged):
        """Where the mesh's own anchors are, ... x k x 3, with the merged ones at ... x r x 3."""
        moves = merged - self._inner_input.anchor_rest
        return self._of.anchor_rest + moves[..., self._places, :]

    def weights(self, weights):
        if weights is None:
            return None
        return self._inner.weights(self._mean_of_claims(weights[..., self._claims], axis=-1))

    def start(self, positions):
        if positions is None:
            return None
        solved = getattr(positions, "solved", None)
        if solved is not None:
            return solved
        return self._inner.start(self._inner_input.rest + self._mean(positions - self._of.rest))

    def cut_back(self, positions):
        moves = np.asarray(self._inner.cut_back(positions)) - self._inner_input.rest
        return Cut.of(self._of.rest + moves[self._merged], positions)

    def cut_back_rows(self, rows):
        cut = np.empty((len(rows), *self._of.rest.shape), np.float32)
        for number, row in enumerate(rows):
            cut[number] = self.cut_back(row)
        return cut
