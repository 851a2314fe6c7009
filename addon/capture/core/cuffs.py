# SPDX-License-Identifier: GPL-3.0-or-later
"""Rings of skin that go along with a limb: markers are on one side of it, and nothing else holds the other.

Between hip and knee skin as thick as the bone is short spreads the bend of both joints over the whole thigh. A *cuff*
is a few vertices around the middle of a limb's segment that move rigidly, as the markers of the segment do.
"""

from dataclasses import dataclass

import numpy as np

from ...scene.core.motion import fit_rotations
from ...scene.core.point_sets import parts
from . import landmarks as places
from .proportions import carried, with_hips

#: Segments of the body that are stiff, long and bent far at both ends, and how strong their cuffs are: where hips are
#: is less sure than where markers are.
LIMBS = {"thigh": 0.85, "shank": 1.0}
#: Radians that a segment's roll may be off: how badly its markers fit it, over how far they are from its axis.
ROLL = 1.0
#: What each of these takes from the strength of a cuff.
DOUBT = 0.4
#: Where the two rings of a cuff are, from the middle, and how thick (radius) a segment may be: over the length that its
#: markers span. Vertices of a cuff: one ring does not hold how a limb is tilted.
RINGS, THICKEST, COUNT = (-0.15, 0.15), 0.3, 6


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
    axis, it gets no cuff; below, the cuff is the softer.

    markers  (f, m, 3) NaN where missing; reference  (m, 3) the same on the mesh at rest; landmarks  m names or None;
    anchors  (m,) vertices that they carry; surface  the mesh's Surface.
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
        paths = moving[:, members]
        turns = fit_rotations(points, paths)
        turns[np.isnan(paths[..., 0]).any(axis=1)] = np.nan  # where one of them is missing
        squares = ((paths - carried(points, paths, turns)) ** 2).sum(axis=2)
        squares = squares[~np.isnan(squares[:, 0])]
        off = float(np.sqrt(squares.mean())) if len(squares) else np.inf
        error = off * np.sqrt(len(members)) / max(across, 1e-300)
        if not error < ROLL:
            refused[name] = error
            continue
        along = (points - middle) @ axis
        middle = middle + 0.5 * (along.min() + along.max()) * axis
        span = np.ptp(along)
        rings = [ring_around(middle + share * span * axis, axis, vertices, triangles) for share in RINGS]
        radius = max(radius for _, _, radius in rings)
        if radius > THICKEST * span:
            continue  # no limb but a trunk
        free = np.setdiff1d(np.concatenate([numbers for numbers, _, _ in rings]), list(taken))
        chosen = free[spread(vertices[free], vertices[anchors[own]], COUNT)].tolist()
        if len(chosen) == COUNT:
            taken |= set(chosen)
            centre = vertices[chosen].mean(axis=0)
            centres = moving[:, own].mean(axis=1) + np.einsum("fij,j->fi", turns, centre - rest[own].mean(axis=0))
            strength = LIMBS[name.split(".")[0]] - DOUBT * error
            cuffs.append(Cuff(name, np.array(chosen), centre, radius, strength, turns, centres))
    return cuffs, refused


def spread(points, held, count):
    """Numbers of at most `count` of points (p, 3), as far from each other and from `held` (h, 3) as can be."""
    chosen = []
    while len(chosen) < min(count, len(points)):
        others = np.concatenate([held, points[chosen]])
        apart = np.linalg.norm(points[:, None] - others, axis=2).min(axis=1, initial=np.inf)
        if not apart.max() > 0.0:
            break
        chosen.append(int(apart.argmax()))
    return chosen


def ring_around(middle, axis, vertices, triangles):
    """(numbers (k,), centre (3,), mean radius) of the vertices (n, 3) where the plane through `middle` (3,) across
    `axis` (3,) cuts the mesh's triangles (t, 3): of the nearest ring; an infinite radius where there is none."""
    is_above = (vertices - middle) @ axis > 0.0
    cut = triangles[is_above[triangles].any(axis=1) & ~is_above[triangles].all(axis=1)]
    part = parts(np.concatenate([cut[:, :2], cut[:, 1:]]), len(vertices))
    numbers = np.unique(cut)
    rings = []
    for first in np.unique(part[numbers]):
        around = numbers[part[numbers] == first]
        points = vertices[around]
        centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
        rings.append((around, centre, float(np.linalg.norm(np.cross(axis, points - centre), axis=1).mean())))
    return min(rings, key=lambda ring: np.linalg.norm(ring[1] - middle), default=(numbers, middle, np.inf))
