# SPDX-License-Identifier: GPL-3.0-or-later
"""Rings of skin that go along with a limb: markers are on one side of it, and nothing else holds the other.

Between hip and knee skin as thick as the bone is short spreads the bend of both joints over the whole thigh. A *cuff*
is a few vertices around the middle of a limb's segment that move rigidly, as the markers of the segment do.
"""

from dataclasses import dataclass

import numpy as np

from ...scene.core.motion import fit_rotations, unit
from ...scene.core.point_sets import parts
from . import landmarks as places
from .proportions import with_hips

#: Segments of the body that are stiff, long and bent far at both ends.
LIMBS = ("thigh", "shank")
#: Radians that a segment's roll may be off: how badly its markers fit it, over how far they are from its axis.
ROLL = 1.0
#: What each of these takes from the strength of a cuff.
DOUBT = 0.4
#: Vertices of a cuff; how thick (radius) a segment may be over the length that its markers span.
COUNT, THICKEST = 5, 0.3


@dataclass(frozen=True, eq=False)
class Cuff:
    """Vertices that move as one over f frames; NaN where one of the markers that tell is away."""

    segment: str  # of the body
    vertices: np.ndarray  # (k,)
    centre: np.ndarray  # (3,) of these at rest
    radius: float  # of the limb there
    strength: float  # from 0 to 1, of the handle: less the farther the roll may be off
    turns: np.ndarray  # (f, 3, 3) from the rest
    centres: np.ndarray  # (f, 3)


def find_cuffs(markers, reference, landmarks, anchors, surface):
    """([Cuff], {segment: how far its roll may be off}) of limbs whose markers tell how they turn, and of the others.

    Where the best rigid motion (Kabsch 1976) is off by more than ROLL of how far the markers are from the segment's
    axis (by their second singular value), its roll is not known, and it gets no cuff; below, the cuff is the softer.

    markers  (f, m, 3) aligned, retargeted, NaN where missing; reference  (m, 3) the same on the mesh at rest; landmarks
    m names or None; anchors  (m,) vertices that they carry; surface  the mesh's Surface.
    """
    # Hips, which go with the pelvis, are the third point of thighs that have two markers.
    rest, moving, names = with_hips(reference, markers, landmarks)
    cuffs, refused, taken = [], {}, set(np.asarray(anchors).tolist())
    vertices, triangles = surface.vertices, surface.triangles
    for name, members in sorted(places.segments(names).items()):
        if name.split(".")[0] not in LIMBS or len(members) < 3:
            continue
        points, middle = rest[members], rest[members].mean(axis=0)
        own = [k for k in members if k < len(anchors)]  # where hips are in a thigh is less sure than how they turn it
        _, (_, across, _), (axis, *_) = np.linalg.svd(points - middle)
        turns, off = _motion(points, moving[:, members])
        error = off * np.sqrt(len(members)) / max(across, 1e-300)
        if not error < ROLL:
            refused[name] = error
            continue
        along = (points - middle) @ axis
        middle = middle + 0.5 * (along.min() + along.max()) * axis
        ring = ring_around(middle, axis, vertices, triangles)
        if ring is None or ring.radius > THICKEST * np.ptp(along):
            continue  # no limb but a trunk
        free = np.setdiff1d(ring.numbers, list(taken))
        chosen = free[spread(ring.ways(vertices[free]), ring.ways(vertices[[anchors[k] for k in own]]), COUNT)].tolist()
        if len(chosen) == COUNT:
            taken |= set(chosen)
            centre = vertices[chosen].mean(axis=0)
            centres = moving[:, own].mean(axis=1) + np.einsum("fij,j->fi", turns, centre - rest[own].mean(axis=0))
            strength = 1.0 - DOUBT * error
            cuffs.append(Cuff(name, np.array(chosen), centre, ring.radius, strength, turns, centres))
    return cuffs, refused


def _motion(rest, moving):
    """((f, 3, 3) turns, rms by which they are off) of markers moving (f, k, 3) as a rigid body, rest (k, 3); NaN in
    frames without all of them."""
    turns, centres = fit_rotations(rest, moving), moving.mean(axis=1)
    turns[np.isnan(centres[:, 0])] = np.nan
    carried = centres[:, None] + np.einsum("fij,kj->fki", turns, rest - rest.mean(axis=0))
    squares = ((moving - carried) ** 2).sum(axis=2)
    squares = squares[~np.isnan(squares[:, 0])]
    return turns, float(np.sqrt(squares.mean())) if len(squares) else np.inf


@dataclass(frozen=True, eq=False)
class Ring:
    """Vertices `numbers` (k,) around `centre` (3,), `radius` from it on average, across `axis` (3,)."""

    numbers: np.ndarray
    centre: np.ndarray
    axis: np.ndarray
    radius: float

    def ways(self, points):
        """(p, 3) unit: from the axis to points (p, 3)."""
        away = points - self.centre
        return unit(away - np.outer(away @ self.axis, self.axis))


def spread(points, held, count):
    """Numbers of at most `count` of points (p, 3), as far from each other and from `held` (h, 3) as can be."""
    chosen = []
    while len(chosen) < min(count, len(points)):
        others = np.concatenate([held, points[chosen]])
        apart = np.linalg.norm(points[:, None] - others, axis=2).min(axis=1, initial=2.0)
        if not apart.max() > 0.0:
            break
        chosen.append(int(apart.argmax()))
    return chosen


def ring_around(middle, axis, vertices, triangles):
    """The `Ring` where the plane through `middle` (3,) across `axis` (3,) cuts the mesh: the nearest one, or None.

    vertices  (n, 3); triangles  (t, 3).
    """
    is_above = (vertices - middle) @ axis > 0.0
    cut = triangles[is_above[triangles].any(axis=1) & ~is_above[triangles].all(axis=1)]
    part = parts(np.concatenate([cut[:, :2], cut[:, 1:]]), len(vertices))
    numbers = np.unique(cut)
    rings = []
    for first in np.unique(part[numbers]):
        around = numbers[part[numbers] == first]
        points = vertices[around]
        centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
        radius = float(np.linalg.norm(np.cross(axis, points - centre), axis=1).mean())
        rings.append(Ring(around, centre, axis, radius))
    return min(rings, key=lambda ring: np.linalg.norm(ring.centre - middle), default=None)
