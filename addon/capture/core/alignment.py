# SPDX-License-Identifier: GPL-3.0-or-later
"""Markers laid onto a mesh: by picked pairs, or by themselves in a standing pose."""

from dataclasses import dataclass

import numpy as np

from ...scene.core import checks
from ...scene.core.surface import Surface, outward
from . import facing, marker_sets
from . import landmarks as places
from .medial import medial_points

#: Share of the markers that must lie on the mesh; the others may be anywhere (arms in another pose, mislabelled ones).
TRIMMED = 0.65
#: Metres from a marker's centre to the skin.
MARKER_RADIUS = 0.007
#: How much each joint of the hips counts beside all others together.
HIPS = 0.5
#: How much markers of arms count: nobody holds them alike.
ARMS = 0.3
#: Points of the surface that the search looks at, and the rounds on them: first few, from every start, then many.
SAMPLES, ROUNDS, FINER_SAMPLES, FINER_ROUNDS = 1500, 8, 12000, 15
#: Turns about the upright axis and scales to start from, where landmarks do not tell them.
TURNS, SCALES = 16, (0.93, 1.0, 1.07)
#: What the scale may differ by from that of the heights of known landmarks, and where none is known.
SCALE_KNOWN, SCALE_UNKNOWN = 0.08, 0.3
#: How much the height of a landmark on an upright body counts beside the surface: along a leg the skin tells nothing.
HEIGHT_COUNTS = 0.25
#: How far (over the body's height) a point of the skin that looks the other way than a marker's seems to be off.
FACING = 0.06
#: How much the way of the feet counts beside the surface, and by how much a body that looks the other way must fit
#: better to be believed: of joints front and back are hard to tell by the surface, but their names tell the sides.
WAY_COUNTS, BACKWARD, BACKWARD_JOINTS = 0.5, 1.3, 2.0


@dataclass(frozen=True, eq=False)
class Alignment:
    """Where markers lie on a mesh."""

    #: (4, 4) from the capture's space to the mesh's: a scale, a turn about +Z, a shift.
    matrix: np.ndarray
    scale: float
    #: Rms distance from markers to the surface of the best 65 %, over the mesh's height: below 0.015 is good.
    quality: float
    #: `quality` of the best other way to look (turned by more than 45 degrees), over this one: near 1 it is a guess.
    certainty: float
    words: str


def similarity(source, target):
    """(4, 4): the scale, rotation and shift that take points closest to others (Umeyama 1991).

    source, target  (k, 3), rows with NaN in either left out. At least 3 that are not on a line must be left.
    Raises InvalidMotionError where they are less, or in one place or on a line.
    """
    source = checks.points(source, "the picked markers")
    target = checks.points(target, "the picked points", len(source))
    known = ~np.isnan(source[:, 0]) & ~np.isnan(target[:, 0])
    if known.sum() < 3:
        raise checks.InvalidMotionError(f"There are {known.sum()} pairs of markers and points; pick at least 3.")
    source, target = source[known], target[known]
    from_centre, to_centre = source.mean(axis=0), target.mean(axis=0)
    before, after = source - from_centre, target - to_centre
    for points, name in ((before, "markers"), (after, "points")):
        spread = np.linalg.svd(points, compute_uv=False)
        if spread[1] <= 1e-6 * spread[0] or spread[0] <= 0.0:
            raise checks.InvalidMotionError(f"The picked {name} lie on one line: pick one more that is off it.")
    left, values, right = np.linalg.svd(after.T @ before)
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(left) * np.linalg.det(right))])
    turn = (left * signs) @ right
    scale = (values * signs).sum() / (before**2).sum()
    return _matrix(turn, scale, to_centre - scale * turn @ from_centre)


def align_to_mesh(markers, labels, vertices, faces, more_sets=()):
    """The `Alignment` of markers with a mesh, without picked pairs. Both stand upright, +Z up, in about the same pose.

    Scale and height come from the heights of known landmarks over the ground (landmarks.py), else from the extent. From
    several turns about the upright axis (near the way that the mesh's feet point, where that is to be seen, and the
    other way; else all round) ICP leads to the surface (Besl and McKay 1992; upright, scaled, trimmed as by Chetverikov
    et al. 2005). Markers of known places look for skin that looks their way, and their heights count a little. A
    marker's centre is its radius off the skin.

    markers  (m, 3) metres, NaN where missing; labels  m names; vertices  (n, 3) any unit; faces  (t, 3) triangles.
    Raises InvalidMotionError for less than 6 markers and for meshes without surface or height.
    """
    markers = checks.points(markers, "the markers")
    if len(labels) != len(markers):
        raise checks.InvalidMotionError(f"There are {len(labels)} names for {len(markers)} markers.")
    known = ~np.isnan(markers[:, 0])
    if known.sum() < 6:
        raise checks.InvalidMotionError(
            f"Only {known.sum()} markers are seen in this frame; the alignment needs 6. Choose another frame or pick "
            "pairs of markers and points."
        )
    surface = Surface(vertices, faces)
    body = _Body(surface)
    if not body.height > 0.0:
        raise checks.InvalidMotionError("The mesh is flat: it has no height along Z. Stand it up, +Z is up.")
    if not np.ptp(markers[known, 2]) > 0.0:
        raise checks.InvalidMotionError("The markers are all at one height. Check the up axis of the take.")
    names = np.array(marker_sets.recognise(labels, more_sets).landmarks, object)[known]
    if places.has_joints(names):
        body.few, body.many = ((medial_points(*some), some[1]) for some in (body.few, body.many))
    fit = _Fit(body, markers[known], names)
    candidates = sorted((fit.settled(start, body.few, ROUNDS) for start in fit.starts()), key=_residual)
    best = min((fit.settled(matrix, body.many, FINER_ROUNDS) for _, matrix in candidates[:3]), key=_residual)
    others = [one for one in candidates if _angle_between(one[1], best[1]) > np.radians(45.0)]
    other = fit.settled(others[0][1], body.many, FINER_ROUNDS)[0] if others else np.inf
    scale, certainty = float(np.cbrt(np.linalg.det(best[1][:3, :3]))), float(other / max(best[0], 1e-300))
    moved = markers[known] @ best[1][:3, :3].T + best[1][:3, 3]
    distances = np.sort(surface.nearest(moved)[3])[: max(4, int(np.ceil(TRIMMED * known.sum())))]
    quality = float(np.sqrt((distances**2).mean()) / body.height)
    words = f"Two of three markers lie within {100.0 * distances[-1] / body.height:.1f} % of the height from the skin"
    words += f"; scaled by {scale:.3g}." + (" Another way to look fits nearly as well." if certainty < 1.1 else "")
    return Alignment(best[1], scale, quality, certainty, words)


def _residual(candidate):
    return candidate[0]


class _Body:
    """What the search needs to know of a mesh: samples of it, its height, and where its feet point."""

    def __init__(self, surface):
        self.surface = surface
        used = surface.vertices[np.unique(surface.triangles)]
        self.ground, self.height = used[:, 2].min(), np.ptp(used[:, 2])
        samples = (surface.samples(count) for count in (SAMPLES, FINER_SAMPLES))
        self.few, self.many = ((points, outward(points, normals)) for points, normals in samples)
        points = self.many[0]
        above = (points[:, 2] - self.ground) / max(self.height, 1e-300)
        trunk = points[(above > 0.5) & (above < 0.62)]
        self.middle = np.median(trunk if len(trunk) else points, axis=0)[:2]
        # From the ankles to what lies on the ground, where that is as long as feet are. Middles of extents: both feet
        # count alike however they stand.
        soles, ankles = points[above < 0.03], points[(above > 0.06) & (above < 0.10)]
        self.looks = None
        if len(soles) > 3 and len(ankles) > 3:
            way = [0.5 * (part.min(axis=0) + part.max(axis=0))[:2] for part in (ankles, soles)]
            way = way[1] - way[0]
            self.looks = way if np.linalg.norm(way) > 0.01 * self.height else None

    def trunk(self):
        """(2,) the middle of the trunk at the hips, without hands that hang beside it."""
        points = self.many[0]
        above = (points[:, 2] - self.ground) / self.height
        centre = np.median(points[above > 0.5], axis=0)[:2]
        near = (above > 0.5) & (above < 0.62) & (np.linalg.norm(points[:, :2] - centre, axis=1) < 0.12 * self.height)
        return np.median(points[near], axis=0)[:2] if near.any() else self.middle


class _Fit:
    """Iterated closest points, upright."""

    def __init__(self, body, markers, names):
        self._body, self._markers = body, markers
        self._radius = 0.0 if places.has_joints(names) else MARKER_RADIUS
        arms = ("upper_arm", "elbow", "forearm", "wrist", "hand")
        self._weights = np.array([ARMS if name and name.split(".")[0] in arms else 1.0 for name in names])
        self._heights = np.array([(place.height if place else None) or np.nan for place in map(places.place_of, names)])
        self._scale, self._base, self._is_known = _scale_by_heights(markers, self._heights, body.height)
        allowed = SCALE_KNOWN if self._is_known else SCALE_UNKNOWN
        self._scales = self._scale * (1.0 - allowed), self._scale * (1.0 + allowed)
        self._looks = facing.forward(markers, names)
        self._faces = facing.of_body(names, self._looks)
        # Joints of the hips are about the middle of the trunk; of markers the skin tells more.
        self._hips = np.array([name in ("hip.L", "hip.R", "pelvis.joint") for name in names])

    def starts(self):
        """Matrices: about the way that the feet point, where both bodies tell it, else all round."""
        if self._looks is None or self._body.looks is None:
            angles = 2.0 * np.pi * np.arange(TURNS) / TURNS
        else:
            angles = self._expected_angle() + np.radians([0.0, -20.0, 20.0, -45.0, 45.0, 180.0])
        trunk = (self._heights > 0.5) & (self._heights < 0.6)
        middle = np.mean(self._markers[trunk], axis=0) if trunk.any() else np.median(self._markers, axis=0)
        origin, to = np.append(middle[:2], self._base), np.append(self._body.middle, self._body.ground)
        return [
            _upright(angle, self._scale * share, to, origin)
            for angle in angles
            for share in ((1.0,) if self._is_known else SCALES)
        ]

    def settled(self, matrix, samples, rounds):
        """(residual, matrix) of the best of some rounds."""
        best = np.inf, matrix
        for _ in range(rounds):
            residual, following = self._round(matrix, samples)
            if residual < best[0]:
                best = residual, matrix
            matrix = following
        return best

    def _round(self, matrix, samples):
        """(residual of `matrix`, the next matrix)."""
        points, normals = samples
        height, scale = self._body.height, np.cbrt(np.linalg.det(matrix[:3, :3]))
        moved = self._markers @ matrix[:3, :3].T + matrix[:3, 3]
        faces = self._faces @ (matrix[:3, :3] / scale).T
        squares = (points**2).sum(axis=1) - 2.0 * moved @ points.T + (moved**2).sum(axis=1)[:, None]
        squares -= (FACING * height) ** 2 * np.minimum(faces @ normals.T, 0.0)
        nearest = squares.argmin(axis=1)
        off = np.sqrt(np.maximum(squares[np.arange(len(moved)), nearest], 0.0))
        target = points[nearest] + scale * self._radius * normals[nearest]
        told = ~np.isnan(self._heights)
        upright = self._body.ground + self._heights[told] * height
        target[told, 2] += HEIGHT_COUNTS * (upright - target[told, 2])
        if self._hips.any():
            target[self._hips, :2] = moved[self._hips, :2] + self._body.trunk() - moved[self._hips, :2].mean(axis=0)
        # Those on the mesh count; arms need not be among them.
        near = np.sort(off)[: max(4, int(np.ceil(TRIMMED * len(off))))]
        sigma = max(float(np.sqrt((near**2).mean())), 0.005 * height)
        weights = self._weights / (1.0 + (off / sigma) ** 2) ** 2
        weights[self._hips] = HIPS * weights.sum()
        residual = float(np.sqrt((self._weights * np.minimum(off, 3.0 * sigma) ** 2).sum() / self._weights.sum()))
        angle = self._expected_angle()
        if angle is not None and _angle_between(_upright(angle, 1.0, 0.0, np.zeros(3)), matrix) > 0.5 * np.pi:
            backward = BACKWARD_JOINTS if self._hips.any() else BACKWARD
            residual, angle = backward * residual, angle + np.pi
        return residual, _upright_similarity(self._markers, target, weights, self._scales, angle)

    def _expected_angle(self):
        if self._looks is None or self._body.looks is None:
            return None
        here, there = (np.arctan2(way[1], way[0]) for way in (self._looks, self._body.looks))
        return there - here


def _scale_by_heights(markers, heights, height):
    """(scale, height of the ground in the capture, True if landmarks told). heights: NaN where none is known."""
    told = ~np.isnan(heights)
    if told.sum() >= 4 and np.ptp(heights[told]) > 0.3:
        # A line through heights of markers over those of landmarks; what is far off it (a bent knee) counts less.
        design, weights = np.stack([heights[told], np.ones(told.sum())], axis=1), np.ones(told.sum())
        for _ in range(5):
            root = np.sqrt(weights)[:, None]
            tall, base = np.linalg.lstsq(root * design, root[:, 0] * markers[told, 2], rcond=None)[0]
            off = np.abs(design @ [tall, base] - markers[told, 2])
            weights = 1.0 / (1.0 + (off / max(np.median(off), 1e-6)) ** 2)
        if tall > 0.0:
            return height / tall, base, True
    return height / (1.02 * np.ptp(markers[:, 2])), markers[:, 2].min() - 0.01 * np.ptp(markers[:, 2]), False


def _upright_similarity(source, target, weights, scales, angle=None):
    """(4, 4): the least-squares scale within bounds, turn about Z (towards `angle`, if given) and shift."""
    shares = weights / weights.sum()
    from_centre, to_centre = shares @ source, shares @ target
    before, after = source - from_centre, target - to_centre
    cosine = (shares * (before[:, 0] * after[:, 0] + before[:, 1] * after[:, 1])).sum()
    sine = (shares * (before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])).sum()
    size = (shares * (before**2).sum(axis=1)).sum()
    scale = (np.hypot(cosine, sine) + (shares * before[:, 2] * after[:, 2]).sum()) / max(size, 1e-300)
    if angle is not None:
        pull = WAY_COUNTS * np.hypot(cosine, sine)
        cosine, sine = cosine + pull * np.cos(angle), sine + pull * np.sin(angle)
    return _upright(np.arctan2(sine, cosine), np.clip(scale, *scales), to_centre, from_centre)


def _upright(angle, scale, to, origin):
    turn = np.array([[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
    return _matrix(turn, scale, to - scale * turn @ origin)


def _matrix(turn, scale, shift):
    result = np.eye(4)
    result[:3, :3] = scale * turn
    result[:3, 3] = shift
    return result


def _angle_between(first, second):
    cross = first[:2, :2].T @ second[:2, :2]
    return abs(np.arctan2(cross[1, 0] - cross[0, 1], cross[0, 0] + cross[1, 1]))
