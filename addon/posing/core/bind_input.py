# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything a binding depends on, as arrays that belong to us."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ... import wording
from ...errors import SceneError
from ...scene.core import motion, point_sets, welding
from ...scene.core.key_shapes import KeyShapes
from ...scene.core.point_sets import require_finite
from ...solver.core.fingerprint import Fingerprint, digest
from . import joints
from .solver_mesh import SolverMesh

#: Of the mesh's size: it is told of where moves so long are taken for rounding.
FAR = 5e-4

#: Stiffness of a soft handle of strength 0 and 1, per unit of rigidity and share of the mesh: a slider of four
#: decades, from hardly felt to hardly giving way. The energy of a shape falls as its mesh gets finer (the squared
#: edge length is its unit), and so must the springs.
WEAKEST = 4e-3
STRONGEST = 4e1

#: The same of a region's soft border, where the weight is a half: as stiff as the shape itself is over the size of the
#: region. A handle in the middle of a flat disk that fades out to its edge takes what has half the weight 0.43 times as
#: far along as it goes itself; with 10 for 1 it is 0.31 times, without springs 0.46 times.
BORDER = 1.0

#: Stands in for a rigidity of 0, where the paper's own energy alone holds the shape.
LEAST_RIGIDITY = 1.0

NO_FACES = "The mesh has no faces. Mean-Value Deform needs a surface: give it faces"


@dataclass(frozen=True, eq=False)
class BindInput:
    """The rest mesh and what is fixed of it. Where there is nothing of a kind, it is None."""

    rest: np.ndarray  # n x 3 float32, object space
    face_corners: np.ndarray  # vertex index of every face corner, int32, faces one after another
    face_starts: np.ndarray  # where each face begins in face_corners, int32
    anchors: np.ndarray  # k vertex indices, int32, ascending, each once
    roi: np.ndarray  # n bool, True may move; anchors may be anywhere
    method: str  # the solver's, see ids
    handles: np.ndarray  # k int32, number of the enabled handle that each anchor belongs to
    rigidity: float | None = None  # how much lengths count; None for methods that do not know it
    stiffness: np.ndarray | None = None  # n float64, how many times as much they count there
    kept_poses: KeyShapes | None = None  # that this is of
    bends: str = ""  # in words, where it bends by that
    limbs: joints.Limbs | None = None  # between whose joints
    #: k float64: of the springs of soft anchors, if only one vertex of their part may move; infinite for hard ones.
    strengths: np.ndarray | None = None
    border: np.ndarray | None = None  # b vertices, int32, ascending, no anchors: free in part, where the region is soft
    border_strengths: np.ndarray | None = None  # b float64, likewise, of those that hold them to the rest shape
    #: p x 4 float64, unit normal and distance of each plane that mirrors the mesh; at right angles to each other.
    planes: np.ndarray | None = None
    #: p x n int32: the vertex that each vertex' image in a plane is joined to, itself in the plane; -1 where the image
    #: is a vertex that the mesh does not have.
    twins: np.ndarray | None = None
    loose: str = "follow"  # what becomes of parts that nothing holds: these, or "stay"
    copies: np.ndarray | None = None  # n int, as of scene/kept.py: one for all of those that are one
    examples: KeyShapes | None = None  # shapes that show how the mesh bends

    @cached_property
    def fingerprint(self):
        arrays = self.border, self.border_strengths, self.planes, self.twins, self.copies
        limbs = () if self.stiffness is None else (self.stiffness,)  # not None: records of before have none
        settings = self.method, self.loose, self.examples and self.examples.revision
        return Fingerprint(
            vertex_count=len(self.rest),
            faces=digest(self.face_starts, self.face_corners),
            rest_shape=digest(self.rest),
            kept=digest(f"{settings}", np.packbits(self.roi), *arrays),
            anchors=digest(self.anchors, self.handles, self.strengths, f"{self.rigidity}", *limbs),
        )

    @property
    def revision(self):
        """Another one where it is bound otherwise, of other shapes, or said to bend elsewhere."""
        return self.fingerprint, self.kept_poses and self.kept_poses.revision, self.bends

    @cached_property
    def solver_mesh(self):
        """What goes to the solver."""
        return SolverMesh(self)

    @cached_property
    def hard_anchors(self):
        """k bool: the anchors that are met exactly."""
        return np.ones(len(self.anchors), bool) if self.strengths is None else np.isinf(self.strengths)

    @cached_property
    def free(self):
        """n bool: the vertices that the solver places, soft anchors among them."""
        free = self.roi.copy()
        free[self.hard_vertices] = False
        return free

    @cached_property
    def fixed(self):
        """Vertex indices of those that stay in the rest shape: outside the region, and no copies of a hard anchor."""
        places = self.solver_mesh.places
        goes_along = np.zeros(int(places.max(initial=-1)) + 1, bool)
        goes_along[places[self.hard_vertices]] = True
        return np.flatnonzero(~self.roi & ~goes_along[places])

    @cached_property
    def hard_vertices(self):
        """Vertex indices of the hard anchors."""
        return self.anchors[self.hard_anchors]

    @cached_property
    def anchor_rest(self):
        """k x 3 float64: the anchors in the rest shape. Not to be written to."""
        return self.rest[self.anchors].astype(np.float64)

    @cached_property
    def is_held(self):
        """n bool: the vertices that something holds in their place: fixed ones and soft anchors."""
        held = ~self.free
        held[self.anchors] = True
        if self.border is not None:
            held[self.border] = True
        return held

    @cached_property
    def diagonal(self):
        """Of the rest shape's bounding box; energies are shown for diagonal 1."""
        return point_sets.bounding_box_diagonal(self.rest)

    @cached_property
    def limits(self):
        """The joints.Limits between what holds the mesh where it is put, or None where joints are not known."""
        if self.limbs is None:
            return None
        numbers = np.unique(self.handles[self.hard_anchors]).tolist()
        hard = {number: self.anchors[self.hard_anchors & (self.handles == number)] for number in numbers}
        return joints.limits(self.limbs, self.rest, {-1: self.fixed, **hard})

    def move_in_planes(self, number, move):
        """Of a 4 x 4 `move` of a handle, by its number, what is the same on both sides of the planes that it lies
        across; an uneven one as it is."""
        if self.planes is None:
            return move
        own = self.anchors[self.handles == number]
        planes = self.planes[np.isin(self.twins[:, own], own).any(axis=1)]
        return motion.in_planes(move, self.rest[own].mean(axis=0, dtype=np.float64), planes)

    @cached_property
    def joined_places(self):
        """How many places have vertices that are one to the solver."""
        return 0 if self.copies is None else int((np.bincount(self.copies) > 1).sum())

    @cached_property
    def notes(self):
        """Sentences on what of the mesh keeps poses from being what the artist expects."""
        found = []
        vertices, distance = welding.gaping(self.rest, self.face_corners, self.face_starts, self.copies, surely=True)
        if len(vertices):
            told = wording.vertices(len(vertices))
            found.append(f"{told} lie nearly in the place of others. Set Advanced > Merge Distance to {distance:g}")
        far = float(np.abs(self.rest).max(initial=0.0))
        if motion.NOISE * far > FAR * self.diagonal:
            found.append(f"The mesh lies {far:,.0f} from its origin: small moves are rounded. Set Origin to Geometry")
        return found

    def check(self):
        """@throws SceneError if this cannot be bound, with what to do about it."""
        if len(self.face_starts) == 0:
            raise SceneError(NO_FACES)
        require_finite(self.rest, "rest shape")
        outside = np.count_nonzero(~self.hard_anchors & ~self.roi[self.anchors])
        if outside:
            raise SceneError(f"{wording.vertices(outside)} of soft handles lie outside the region. Turn Soft off")
        held = self.solver_mesh.held_rest
        if self.free.any() and not point_sets.span_a_plane(held):
            count = wording.counted(len(held), "fixed point")
            raise SceneError(f"{count} cannot hold the mesh. Pin at least three that are not in one line")


def anchor_layout(members):
    """(anchors, handles): ascending vertex indices of all handles, each once, and the number of the one that has it.

    members: of each handle. A vertex of several handles belongs to the first.
    """
    indices = np.concatenate([np.empty(0, np.int32), *members]).astype(np.int32)
    numbers = np.concatenate([np.empty(0, np.int32), *(np.full(len(g), i) for i, g in enumerate(members))])
    anchors, first = np.unique(indices, return_index=True)
    return anchors, numbers[first].astype(np.int32)


def spring_strengths(handles, handle_strengths, rigidity):
    """k float64 for k anchors with handle numbers `handles`; None if no handle is soft.

    handle_strengths: of each handle 0 to 1, None if it is hard: its spring is shared out among its vertices, so that a
    finer mesh makes it no stiffer.
    """
    if all(strength is None for strength in handle_strengths):
        return None
    result = np.full(len(handles), np.inf)
    for number, strength in enumerate(handle_strengths):
        members = handles == number
        if strength is not None and members.any():
            total = max(rigidity, LEAST_RIGIDITY) * WEAKEST * (STRONGEST / WEAKEST) ** strength
            result[members] = total / np.count_nonzero(members)
    return result


def soft_border(weights, anchors, rigidity):
    """(border, border_strengths) as of BindInput from n region weights w, 0 to 1; (None, None) if they are yes or no.
    Those between are free near 1 and held to the rest shape near 0: s = K (1 - w)/w."""
    is_border = (weights > 0.0) & (weights < 1.0)
    is_border[anchors] = False
    border = np.flatnonzero(is_border).astype(np.int32)
    if len(border) == 0:
        return None, None
    return border, max(rigidity, LEAST_RIGIDITY) * BORDER * (1.0 - weights[border]) / weights[border]
