# SPDX-License-Identifier: GPL-3.0-or-later
"""Arms and legs of a reference frame brought into the pose of the mesh: hardly anybody stands as the mesh does."""

import numpy as np

from . import checks
from .hip_centres import with_hips
from .landmarks import has_joints, side_of
from .medial import medial_points
from .rigid import fit_rotations, turns_between
from .surface import Surface

ARM = (("upper_arm", "elbow"), ("forearm", "wrist", "hand"), "elbow")
LEG = (("thigh", "knee"), ("shank", "ankle", "heel", "toe"), "knee")
#: Points of the surface; directions that a limb is tried in; rounds of refinement; the joint of the shoulder below its
#: marker, over the body's height.
SAMPLES, DIRECTIONS, ROUNDS, BELOW = 12000, 1500, 12, 0.03
#: What is the skin of an arm: so far beyond the shoulder and above the ground, and reaching so far from it, over the
#: body's height. The trunk is as near to an arm that hangs down as an arm is. Legs are below LEGS.
BEYOND, HANDS, LEAST_ARM, LEGS = 0.012, 0.35, 0.25, 0.45
#: Cosine of how far a limb may point from the skin at its end; how much nearer to its skin it must come.
NEAR_TIP, BETTER = np.cos(np.radians(30.0)), 0.7


def pose_limbs(markers, landmarks, vertices, triangles):
    """(m, 3): the aligned markers with arms and legs turned, about their joints, to where the mesh has them.

    Arms are stretched out. Each limb is tried in all directions about that of the skin that is farthest out (arms) or
    lowest (legs) on its side; the best one is refined by ICP, first for the whole limb about shoulder or hip, then for
    what is beyond elbow or knee. Only skin beyond the shoulder is an arm's, so arms of a mesh that lie at its sides are
    not followed. Lengths stay the actor's. A limb that would not lie much nearer to its skin is left alone.
    Joints of a skeleton look for the middle of the limb in place of its skin.
    What comes out takes the place of the reference everywhere: in `match_to_surface()`, `skin_targets()`, `retarget()`.

    markers  (m, 3) aligned with the mesh, NaN where missing; landmarks  m names or None; vertices  (n, 3); triangles
    (t, 3). Arms need markers (or joints) of shoulder and elbow, legs of knee and pelvis or hip, or they are left alone.
    """
    landmarks = tuple(landmarks)
    markers = checks.points(markers, "the markers")
    if len(landmarks) != len(markers):
        raise checks.InvalidMotionError(f"There are {len(landmarks)} landmarks for {len(markers)} markers.")
    samples, normals = Surface(vertices, triangles).samples(SAMPLES)
    if has_joints(landmarks):
        samples = medial_points(samples, normals)
    above = (samples[:, 2] - samples[:, 2].min()) / max(np.ptp(samples[:, 2]), 1e-300)
    hips = _hips(markers, landmarks)
    result = markers.copy()
    for number, side in enumerate("LR"):
        shoulder, other = (_middle(markers, landmarks, which, "shoulder") for which in (side, "RL"[number]))
        if shoulder is not None and other is not None:
            below = 0.0 if f"shoulder.joint.{side}" in landmarks else BELOW * np.ptp(samples[:, 2])
            shoulder, out = shoulder - [0.0, 0.0, below], _level(shoulder - other)
            far, height = (samples - shoulder) @ out, np.ptp(samples[:, 2])
            skin = samples[(far > BEYOND * height) & (above > HANDS)]
            if len(skin) and np.linalg.norm(skin - shoulder, axis=1).max() > LEAST_ARM * height:
                _pose(result, landmarks, side, ARM, shoulder, skin, skin @ out)
        if len(hips):
            hip, out = hips[number], _level(hips[number] - hips[1 - number])
            skin = samples[((samples - hips.mean(axis=0)) @ out > 0.0) & (above < LEGS)]
            if len(skin):
                _pose(result, landmarks, side, LEG, hip, skin, -skin[:, 2])
    return result


def _hips(markers, landmarks):
    """(2, 3) left and right: as captured, or from the markers of the pelvis; empty where neither is there."""
    if {"hip.L", "hip.R"} <= set(landmarks):
        hips = markers[[landmarks.index("hip.L"), landmarks.index("hip.R")]]
        return hips[:0] if np.isnan(hips).any() else hips
    return with_hips(markers, markers, markers[None], landmarks)[0][len(markers) :]


def _pose(markers, landmarks, side, parts, joint, skin, outermost):
    """Turns the markers of one limb where they lie better then. outermost (s,): where of its skin (s, 3) the end is."""
    upper, fore, middle = (_numbers(markers, landmarks, side, names) for names in (*parts[:2], parts[2:]))
    if not middle or len(skin) < 20:
        return
    limb = _Limb(markers, joint, upper, fore, middle, skin)
    tip = skin[outermost >= np.quantile(outermost, 0.95)].mean(axis=0)
    posed = limb.posed(tip, is_stretched=parts is ARM)
    if limb.residual(posed) < BETTER * limb.residual(markers):
        markers[upper + fore] = posed[upper + fore]


def _numbers(markers, landmarks, side, names):
    return [
        number
        for number, name in enumerate(landmarks)
        if side_of(name) == side and name.split(".")[0] in names and not np.isnan(markers[number, 0])
    ]


def _middle(markers, landmarks, side, name):
    numbers = _numbers(markers, landmarks, side, (name,))
    return markers[numbers].mean(axis=0) if numbers else None


def _level(way):
    way = way * [1.0, 1.0, 0.0]
    return way / max(np.linalg.norm(way), 1e-300)


class _Limb:
    def __init__(self, markers, joint, upper, fore, middle, samples):
        self._markers, self._joint, self._samples = markers, joint, samples
        self._upper, self._fore, self._middle = upper, fore, middle
        self._all = upper + fore

    def residual(self, markers):
        """Rms distance of the limb's markers from its skin."""
        _, distances = self._nearest(markers[self._all])
        return float(np.sqrt((distances**2).mean()))

    def posed(self, tip, is_stretched):
        straight = self._stretched() if is_stretched else self._markers
        way = straight[self._all].mean(axis=0) - self._joint
        directions = _all_round(DIRECTIONS)
        tip = tip - self._joint
        directions = directions[directions @ tip > NEAR_TIP * np.linalg.norm(tip)]
        turns = turns_between(np.broadcast_to(way, directions.shape), directions)
        around = straight[self._all] - self._joint
        tried = self._joint + np.einsum("dij,kj->dki", turns, around)
        _, distances = self._nearest(tried.reshape(-1, 3))
        best = turns[(distances.reshape(len(turns), -1) ** 2).sum(axis=1).argmin()]
        posed = straight.copy()
        posed[self._all] = self._joint + around @ best.T
        for numbers in (self._all, self._fore, self._all, self._fore):
            if numbers:
                pivot = self._joint if numbers is self._all else posed[self._middle].mean(axis=0)
                posed[numbers] = self._settled(posed[numbers], pivot)
        return posed

    def _stretched(self):
        """The markers with what is beyond the elbow turned on in line with the upper arm."""
        result = self._markers.copy()
        if self._fore:
            elbow = result[self._middle].mean(axis=0)
            beyond = result[self._fore] - elbow
            turn = turns_between(beyond.mean(axis=0), elbow - self._joint)
            result[self._fore] = elbow + beyond @ turn.T
        return result

    def _settled(self, points, pivot):
        for _ in range(ROUNDS):
            target, _ = self._nearest(points)
            # The pivot stays: it counts as much as all the others.
            before = np.vstack([points, 2.0 * pivot - points])
            after = np.vstack([target, 2.0 * pivot - target])
            points = pivot + (points - pivot) @ fit_rotations(before, after).T
        return points

    def _nearest(self, points):
        """(nearest sample of each of points (k, 3), distance), some thousand at a time."""
        nearest, squares = np.empty(len(points), np.int64), (self._samples**2).sum(axis=1)
        for begin in range(0, len(points), 500):
            part = slice(begin, begin + 500)
            nearest[part] = (squares - 2.0 * points[part] @ self._samples.T).argmin(axis=1)
        return self._samples[nearest], np.linalg.norm(self._samples[nearest] - points, axis=1)


def _all_round(count):
    """(count, 3) unit vectors, evenly on the sphere (Fibonacci's spiral)."""
    k = np.arange(count) + 0.5
    z, angle = 1.0 - 2.0 * k / count, np.pi * (1.0 + 5.0**0.5) * k
    return np.stack([np.sqrt(1.0 - z**2) * np.cos(angle), np.sqrt(1.0 - z**2) * np.sin(angle), z], axis=1)
