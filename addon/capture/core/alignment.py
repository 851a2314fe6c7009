# SPDX-License-Identifier: GPL-3.0-or-later
"""Markers laid onto a mesh: by picked pairs, or by themselves in a standing pose."""

import itertools
from dataclasses import dataclass
from operator import itemgetter

import numpy as np

from ...errors import InvalidMotionError
from ...scene.core import motion
from ...scene.core.motion import about, nearest_rotations, turns_between, unit
from . import facing
from . import landmarks as places
from .body import Body

UP = np.array([0.0, 0.0, 1.0])
#: Share of the markers that must lie on the mesh; the others may be anywhere (arms in another pose, mislabelled ones).
TRIMMED = 0.65
#: Meters from a marker's center to the skin.
MARKER_RADIUS = 0.007
#: How much markers of arms count, and of legs of who sits, crouches or has a foot so far ahead (over the height).
LIMBS, STEP = 0.3, 0.08
#: Points of the body that the search looks at first, from every start, and its rounds on them; then on all.
FEW, ROUNDS, FINER_ROUNDS = 1500, 8, 30
#: Difference of heights of two landmarks on one part that tells its length. Who is less tall than BENT times what the
#: lengths of the parts make of him sits or crouches: these count then, and the trunk is laid on the mesh's.
PART, BENT = 0.15, 0.8
#: Turns about the upright axis to start from, where landmarks do not tell the way.
TURNS = 16
#: What the scale may differ by from that of the heights of known landmarks, of lengths, and where none is known.
SCALE_KNOWN, SCALE_BENT, SCALE_UNKNOWN = 0.08, 0.02, 0.3
#: Meters of a person, and of which share a mesh or what is captured of one is at least as tall.
PERSON, LOW = 1.75, 0.7
#: How much the height of a landmark on an upright body counts beside the surface: along a leg the skin tells nothing.
HEIGHT_COUNTS = 0.25
#: Degrees by which the surface may turn a body from the way that its landmarks tell: legs in a step or arms that swing
#: would turn it farther.
WAY_KNOWN = 4.5
#: By how much a body that looks the other way than the mesh's feet point must fit better to be believed: of joints
#: front and back are hard to tell by the surface, but their names tell the sides.
BACKWARD, BACKWARD_JOINTS = 1.3, 2.0


@dataclass(frozen=True, eq=False)
class Alignment:
    """Where markers lie on a mesh."""

    #: (4, 4) from the capture's space to the mesh's: a scale, a turn about +Z, a shift.
    matrix: np.ndarray
    #: Rms distance from markers to the surface of the best 65 %, over the mesh's height: below 0.015 is good.
    quality: float
    #: How much worse the best other way to look fits (turned by more than 45 degrees): near 1 it is a guess.
    certainty: float

    @property
    def scale(self):
        return _scale_of(self.matrix)


def similarity(source, target):
    """(4, 4): the scale, rotation and shift that take points closest to others (Umeyama 1991).

    source, target  (k, 3), at least 3 that are not on a line.
    """
    from_centre, to_centre = source.mean(axis=0), target.mean(axis=0)
    before, after = source - from_centre, target - to_centre
    turn = nearest_rotations(after.T @ before)
    return _matrix(turn, ((before @ turn.T) * after).sum() / (before**2).sum(), to_centre, from_centre)


def align_to_mesh(markers, landmarks, body):
    """The `Alignment` of markers with a Body, without picked pairs. Both stand upright, +Z up, in about the same pose.

    Scale and height come from the heights of known landmarks (landmarks.py), of who sits from the lengths of the parts,
    else from the extent; the turn from where both sides of the trunk are and the mesh's feet point, if they tell, else
    all are tried. ICP leads to the surface (Besl and McKay 1992; trimmed as by Chetverikov et al. 2005), or for joints
    to the middle of the body.

    markers  (m, 3) meters; landmarks  m names or None.
    Raises InvalidMotionError for less than 6 markers, and for markers or meshes without height.
    """
    if len(markers) < 6:
        raise InvalidMotionError(
            f"Only {len(markers)} markers are seen in this frame; the alignment needs 6. Choose another frame or pick "
            "pairs of markers and points."
        )
    if not body.height > 0.0:
        raise InvalidMotionError("The mesh is flat: it has no height along Z. Stand it up, +Z is up.")
    if not np.ptp(markers[:, 2]) > 0.0:
        raise InvalidMotionError("The markers are all at one height. Check the up axis of the take.")
    fit, few = _Fit(body, markers, landmarks), Body(body.surface, body.is_for_joints, FEW)
    candidates = sorted((fit.settled(start, few, ROUNDS) for start in fit.starts()), key=itemgetter(0))
    best = min((fit.settled(matrix, body, FINER_ROUNDS) for _, matrix in candidates[:3]), key=itemgetter(0))
    others = [matrix for _, matrix in candidates if _angle_between(matrix, best[1]) > np.radians(45.0)]
    other = fit.settled(others[0], body, FINER_ROUNDS)[0] if others else np.inf
    certainty = float(other / max(best[0], 1e-300))
    distances = np.sort(body.surface.nearest(motion.apply(best[1], markers))[3])[: _most(len(markers))]
    return Alignment(best[1], float(np.sqrt((distances**2).mean()) / body.height), certainty)


def _most(count):
    return max(4, int(np.ceil(TRIMMED * count)))


def _middle(body):
    """(2,): the middle of the trunk, seen from above."""
    trunk = body.skin[(body.above > 0.5) & (body.above < 0.62)]
    return np.median(trunk if len(trunk) else body.skin, axis=0)[:2]


def _feet_point(body):
    """(2,): from the ankles to what lies on the ground, where that is as long as feet are; else None."""
    soles, ankles = body.skin[body.above < 0.03], body.skin[(body.above > 0.06) & (body.above < 0.10)]
    if len(soles) <= 3 or len(ankles) <= 3:
        return None
    # Middles of extents: both feet count alike however they stand.
    begin, end = (0.5 * (part.min(axis=0) + part.max(axis=0))[:2] for part in (ankles, soles))
    return end - begin if np.linalg.norm(end - begin) > 0.01 * body.height else None


class _Fit:
    """Iterated closest points, upright."""

    def __init__(self, body, markers, names):
        self._body, self._markers = body, markers
        self._radius = 0.0 if body.is_for_joints else MARKER_RADIUS
        self._heights = heights = places.heights_of(names)
        self._is_trunk = (heights > 0.5) & (heights < 0.6)
        self._scale, self._base, allowed = _scale_by_heights(markers, names, heights, body.height)
        is_limb = np.array([bool(name) and name.split(".")[0] in places.ARM for name in names])
        looks, feet = facing.forward(markers, names), _feet_point(body)
        ahead = markers[:, :2] @ (np.zeros(2) if looks is None else unit(looks))
        step = np.ptp([ahead[foot].mean() for foot in places.feet(names).values()] or [0.0])
        stands = allowed != SCALE_BENT and step * self._scale < STEP * body.height
        self._weights = np.where(is_limb | ((heights < 0.5) & (not stands)), LIMBS, 1.0)
        self._scales = self._scale * (1.0 - allowed), self._scale * (1.0 + allowed)
        #: Angle about Z that has the markers look as the mesh's feet point, or None.
        self._turned = None
        if looks is not None and feet is not None:
            self._turned = np.arctan2(*feet[::-1]) - np.arctan2(*looks[::-1])

    def starts(self):
        """Matrices: about the way that the feet point, where both bodies tell it, else all round."""
        angles = 2.0 * np.pi * np.arange(TURNS) / TURNS
        if self._turned is not None:
            angles = self._turned + np.radians([0.0, -20.0, 20.0, -45.0, 45.0, 180.0])
        trunk = self._markers[self._is_trunk, :2]
        middle = trunk.mean(axis=0) if len(trunk) else np.median(self._markers[:, :2], axis=0)
        origin = np.append(middle, self._base)
        to = np.append(_middle(self._body), self._body.ground)
        return [_matrix(about(UP, angle), self._scale, to, origin) for angle in angles]

    def settled(self, matrix, body, rounds):
        """(residual, matrix) of the best of so many rounds on the points of a Body."""
        best, matrix = (np.inf, matrix), self._round(matrix, body)[1]  # a start may look any way
        for _ in range(rounds):
            residual, following = self._round(matrix, body)
            if residual < best[0]:
                best = residual, matrix
            matrix = following
        return best

    def _round(self, matrix, body):
        """(residual of `matrix`, the next matrix)."""
        points, normals = body.points, body.normals
        moved = motion.apply(matrix, self._markers)
        squares = (points**2).sum(axis=1) - 2.0 * moved @ points.T + (moved**2).sum(axis=1)[:, None]
        nearest = squares.argmin(axis=1)
        off = np.sqrt(np.maximum(squares.min(axis=1), 0.0))
        target = points[nearest] + _scale_of(matrix) * self._radius * normals[nearest]
        told = ~np.isnan(self._heights)
        upright = self._body.ground + self._heights[told] * self._body.height
        target[told, 2] += HEIGHT_COUNTS * (upright - target[told, 2])
        # Those on the mesh count; arms need not be among them.
        near = np.sort(off)[: _most(len(off))]
        sigma = max(float(np.sqrt((near**2).mean())), 0.005 * self._body.height)
        residual = float(np.sqrt((self._weights * np.minimum(off, 3.0 * sigma) ** 2).sum() / self._weights.sum()))
        towards = self._turned
        if towards is not None and _angle_between(about(UP, towards), matrix) > 0.5 * np.pi:
            residual *= BACKWARD_JOINTS if self._body.is_for_joints else BACKWARD
            towards += np.pi
        weights = self._weights / (1.0 + (off / sigma) ** 2) ** 2
        return residual, _upright_similarity(self._markers, target, weights, self._scales, towards)


def _tall_by_parts(markers, names, heights):
    """How tall the body is by the lengths of its parts, whatever its pose; 0 where none is known."""
    lengths = []
    for one, other in itertools.chain(*(itertools.combinations(each, 2) for each in places.segments(names).values())):
        apart = abs(heights[one] - heights[other])
        if apart > PART and {places.side_of(names[one]), places.side_of(names[other])} != {"L", "R"}:
            lengths.append(np.linalg.norm(markers[one] - markers[other]) / apart)
    return float(np.median(lengths)) if lengths else 0.0


def _tall_by_heights(markers, heights):
    """(how tall the body is, height of the ground) by how high its landmarks are; NaN where these do not tell."""
    told = ~np.isnan(heights)
    if told.sum() < 4 or np.ptp(heights[told]) <= 0.3:
        return np.nan, np.nan
    # A line through heights of markers over those of landmarks; what is far off it (a bent knee) counts less.
    design, weights = np.stack([heights[told], np.ones(told.sum())], axis=1), np.ones(told.sum())
    for _ in range(5):
        root = np.sqrt(weights)[:, None]
        tall, base = np.linalg.lstsq(root * design, root[:, 0] * markers[told, 2], rcond=None)[0]
        off = np.abs(design @ [tall, base] - markers[told, 2])
        weights = 1.0 / (1.0 + (off / max(np.median(off), 1e-6)) ** 2)
    return tall, base


def stood_up(markers, names, ground):
    """(m, 3): the markers of who sits, crouches or lies, turned and raised as a whole so that his trunk is where he has
    it who stands on the `ground`, a height in meters; those of others as they are. Legs are posed later."""
    heights = places.heights_of(names)
    by_parts, pelvis, upper = _tall_by_parts(markers, names, heights), (heights > 0.5) & (heights < 0.6), heights > 0.7
    if not (_tall_by_heights(markers, heights)[0] < BENT * by_parts and pelvis.any() and upper.any()):
        return markers
    middle = markers[pelvis].mean(axis=0)
    turn = turns_between(markers[upper].mean(axis=0) - middle, UP)
    return (markers - middle) @ turn.T + [*middle[:2], ground + by_parts * heights[pelvis].mean()]


def _scale_by_heights(markers, names, heights, height):
    """(scale, height of the ground in the capture, what the scale may differ by). heights: NaN where none is known."""
    tall, base = _tall_by_heights(markers, heights)
    by_parts, trunk = _tall_by_parts(markers, names, heights), heights > 0.5
    if tall < BENT * by_parts:
        return height / by_parts, np.median(markers[trunk, 2] - by_parts * heights[trunk]), SCALE_BENT
    if tall > 0.0:
        return height / tall, base, SCALE_KNOWN
    tall = np.ptp(markers[:, 2])
    if tall < LOW * PERSON < height < PERSON / LOW:  # a part of a person, over the ground of the capture
        return height / PERSON, min(0.0, markers[:, 2].min()), SCALE_KNOWN
    return height / (1.02 * tall), markers[:, 2].min() - 0.01 * tall, SCALE_UNKNOWN


def _upright_similarity(source, target, weights, scales, towards):
    """(4, 4): the least-squares scale within bounds, turn about Z (near an angle, or None) and shift."""
    shares = weights / weights.sum()
    from_centre, to_centre = shares @ source, shares @ target
    before, after = source - from_centre, target - to_centre
    cosine = (shares * (before[:, 0] * after[:, 0] + before[:, 1] * after[:, 1])).sum()
    sine = (shares * (before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])).sum()
    size = (shares * (before**2).sum(axis=1)).sum()
    scale = (np.hypot(cosine, sine) + (shares * before[:, 2] * after[:, 2]).sum()) / max(size, 1e-300)
    angle = np.arctan2(sine, cosine)
    if towards is not None:
        off, most = (angle - towards + np.pi) % (2.0 * np.pi) - np.pi, np.radians(WAY_KNOWN)
        angle = towards + np.clip(off, -most, most)
    return _matrix(about(UP, angle), np.clip(scale, *scales), to_centre, from_centre)


def _matrix(turn, scale, to, origin):
    return motion.affine(scale * turn, to - scale * turn @ origin)


def _scale_of(matrix):
    return float(np.cbrt(np.linalg.det(matrix[:3, :3])))


def _angle_between(first, second):
    cross = first[:2, :2].T @ second[:2, :2]
    return abs(np.arctan2(cross[1, 0] - cross[0, 1], cross[0, 0] + cross[1, 1]))
