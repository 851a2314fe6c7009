# SPDX-License-Identifier: GPL-3.0-or-later
"""Arms and legs of a reference frame brought into the pose of the mesh, turned about their joints until they lie on its
skin: hardly anybody stands as the mesh does."""

import numpy as np

from ...scene.core.motion import about, fit_rotations, turns_between, unit
from . import facing, proportions
from .landmarks import heights_of, side_of
from .proportions import hips_of

#: Rolls that a part of a limb is tried in; rounds of refinement.
ROLLS, ROUNDS = 36, 12
#: How often both parts of a limb are turned by themselves.
ALONE = 3
#: How far (over the body's height) a point of the skin that looks across the way of a marker's seems to be off.
FACING = 0.05
#: The cosine of the bend of a knee that sits, crouches or steps.
BENT = np.cos(np.radians(22.0))


class Limb:
    """A limb of a reference (m, 3).

    joint (3,) that it turns about; upper, fore: numbers of the markers before and beyond the joint in its middle, which
    is where the markers `middle` are; samples, normals (s, 3) of its skin; faces (m, 3) where the skin at each marker
    looks, of length 1 or less where that is not sure, 0 where it is not known, or None; height of the body; end: those
    beyond that are in line with it when it is stretched (toes are not), all of them if there is none.
    """

    def __init__(self, markers, joint, upper, fore, middle, samples, normals, faces, height, end=None):
        self._markers, self._joint, self._samples, self._normals = markers.copy(), joint, samples, normals
        self._upper, self._fore, self._middle = upper, fore, middle
        self._faces, self._reach = np.zeros_like(markers) if faces is None else faces, FACING * height
        self.numbers, self._end = upper + fore, end or fore

    def residual(self, markers):
        """Rms distance of the limb's markers from its skin; more where that looks another way."""
        return float(np.sqrt(self._nearest(markers[self.numbers], self.numbers)[1].mean()))

    def is_bent(self):
        """Whether its middle is bent as nobody's is who stands."""
        middle = self._markers[self._middle].mean(axis=0)
        beyond = self._markers[self._end].mean(axis=0) - middle if self._fore else middle - self._joint
        return bool(unit(beyond) @ unit(middle - self._joint) < BENT)

    def posed(self, tip, is_stretched, ways=None):
        """(m, 3): the reference on its skin, with its end at tip (3,). ways (2, 3): where a foot points and is to."""
        posed, is_rolled = self._markers.copy(), is_stretched and ways is not None and ways.any(axis=1).all()
        if is_stretched and self._fore:  # what is beyond the elbow is turned on in line with the upper arm
            elbow = posed[self._middle].mean(axis=0)
            turn = turns_between(posed[self._end].mean(axis=0) - elbow, elbow - self._joint)
            posed[self._fore] = elbow + (posed[self._fore] - elbow) @ turn.T
            if is_rolled:
                axis = unit(tip - self._joint)
                first = turns_between(elbow - self._joint, axis)
                points = np.stack([first @ turn @ ways[0], ways[1]])
                whole = turns_between(*(points - np.outer(points @ axis, axis))) @ first
                posed[self.numbers] = self._joint + (posed[self.numbers] - self._joint) @ whole.T
        around = posed[self.numbers] - self._joint
        posed[self.numbers] = self._joint + around @ turns_between(around.mean(axis=0), tip - self._joint).T
        for numbers in filter(None, (self.numbers, self._fore) * 2):
            pivot = self._joint if numbers is self.numbers else posed[self._middle].mean(axis=0)
            rolled = posed[numbers] if is_rolled else self._rolled(posed[numbers], numbers, pivot)
            posed[numbers] = self._settled(rolled, numbers, pivot)
        return self._part_by_part(posed) if ways is None and self._fore else posed

    def _part_by_part(self, posed):
        """`posed`, or what comes of it where the upper part turns by itself, and the other goes along: rolled as the
        hand lies, a limb may have its elbow on the wrong side of the arm."""
        tried, pivot = posed.copy(), posed[self._middle].mean(axis=0)
        for _ in range(ALONE):
            tried[self._upper] = self._settled(tried[self._upper], self._upper, self._joint)
            before, pivot = pivot, tried[self._middle].mean(axis=0)
            rolled = self._rolled(tried[self._fore] + pivot - before, self._fore, pivot)
            tried[self._fore] = self._settled(rolled, self._fore, pivot)
        return min(posed, tried, key=self.residual)

    def foot(self, posed, foot, ankle):
        """(k, 3): the markers `foot` of `posed` as flat as in the reference, turned about the upright axis alone."""
        pivot = posed[ankle].mean(axis=0)
        level = pivot + self._markers[foot] - self._markers[ankle].mean(axis=0)
        return self._settled(level, foot, pivot, (0.0, 0.0, 1.0))

    def _rolled(self, points, numbers, pivot):
        """The points turned about the axis from the pivot to their middle, as far as lets them look their way."""
        if not self._faces[numbers].any():
            return points
        angles = 2.0 * np.pi * np.arange(ROLLS) / ROLLS
        axis = points.mean(axis=0) - pivot
        tried = pivot + np.einsum("rij,kj->rki", about(axis, angles), points - pivot)
        costs = self._nearest(tried.reshape(-1, 3), np.tile(numbers, ROLLS))[1]
        return tried[costs.reshape(ROLLS, -1).sum(axis=1).argmin()]

    def _settled(self, points, numbers, pivot, axis=(0.0, 0.0, 0.0)):
        kept = np.array(axis)  # else what is flat would be turned over, where its mirror image fits better
        for _ in range(ROUNDS):
            target, _ = self._nearest(points, numbers)
            before, after = (np.vstack([(each - pivot) * (1.0 - kept), kept]) for each in (points, target))
            # The pivot stays: it counts as much as all the others.
            turn = fit_rotations(np.vstack([before, -before]), np.vstack([after, -after]))
            points = pivot + (points - pivot) @ turn.T
        return points

    def _nearest(self, points, numbers):
        """(the sample that suits each of points (k, 3) best, its square distance and what it looks another way)."""
        found, faces = (self._samples**2).sum(axis=1) - 2.0 * points @ self._samples.T, self._faces[numbers]
        found += self._reach**2 * (np.linalg.norm(faces, axis=1)[:, None] - faces @ self._normals.T)
        costs = found.min(axis=1) + (points**2).sum(axis=1)
        return self._samples[found.argmin(axis=1)], np.maximum(costs, 0.0)


ARM = (("upper_arm", "elbow"), ("forearm", "wrist", "hand"), "elbow")
LEG = (("thigh", "knee"), ("shank", "ankle", "heel", "toe"), "knee")
FOOT = (("heel", "toe"), ("ankle",))
#: The joint of the shoulder below its marker, over the body's height.
BELOW = 0.03
#: What is the skin of an arm: so far beyond the shoulder and above the ground, to be reached by steps of REACH from
#: what is within ROOT of the shoulder, and as long as LEAST_ARM, all over the body's height. The trunk is as near to an
#: arm that hangs down as an arm is. Legs are below LEGS.
BEYOND, HANDS, REACH, ROOT, LEAST_ARM, LEGS = 0.012, 0.35, 0.02, 0.1, 0.25, 0.45
#: How much nearer to its skin a limb must come.
BETTER = 0.7


def posed_and_actor(markers, landmarks, body):
    """(posed, actor), (m, 3) each: the aligned markers with arms and legs turned, about their joints, to where the mesh
    has them, and these with the actor's own lengths, which is the reference that `retarget()` needs.

    Arms are stretched out, and legs whose knee is bent. Each limb is turned to the end of its skin and rolled about
    that, then refined by ICP, first the whole limb, then what is beyond elbow or knee. Markers look for skin that looks
    their way (facing.py), joints for the middle of the limb. Only skin beyond the shoulder is an arm's: arms of a mesh
    that lie at its sides are not followed. A limb that would not lie much nearer to its skin is left alone. Where legs
    are unusual, markers go to their heights first (proportions.py).

    markers  (m, 3) aligned with the Body; landmarks  m names or None. Arms need markers (or joints) of shoulder and
    elbow, legs of knee and pelvis or hip, or they are left alone.
    """
    looks = facing.forward(markers, landmarks)
    crotch = proportions.crotch_of(body)
    markers = proportions.moved(markers, landmarks, body, proportions.CROTCH, crotch)
    hips = hips_of(markers, landmarks)
    result = markers.copy()
    for number, side in enumerate("LR"):
        own, other = (markers[_numbers(landmarks, which, ("shoulder",))] for which in (side, "RL"[number]))
        if len(own) and len(other):
            shoulder, below = own.mean(axis=0), 0.0 if body.is_for_joints else BELOW * body.height
            across = shoulder - other.mean(axis=0)
            _pose_arm(result, landmarks, side, shoulder - [0.0, 0.0, below], across, body, looks)
        if len(hips):
            out = _level(hips[number] - hips[1 - number])
            is_leg = ((body.points - hips.mean(axis=0)) @ out > 0.0) & (body.above < LEGS)
            ahead = np.cross(_level(hips[1] - hips[0]), [0.0, 0.0, -1.0])
            faces = None if body.is_for_joints else facing.of_limb(landmarks, facing.LEG, out, ahead)
            _pose_leg(result, landmarks, side, hips[number], body, is_leg, faces, ahead)
    return result, proportions.moved(result, landmarks, body, crotch, proportions.CROTCH)


def _pose_arm(markers, landmarks, side, shoulder, across, body, looks):
    """Turns the markers of one arm where they lie better then. across (3,): to its shoulder from the other one."""
    is_arm, from_tip = _arm(body, shoulder, across)
    if not is_arm.any():
        return
    skin = body.points[is_arm]
    # Joints are inside, where nothing looks anywhere.
    hand = None if body.is_for_joints else facing.hand_of(skin, from_tip, side, body.height, looks)
    faces = None if hand is None else facing.of_limb(landmarks, facing.ARM, *hand)
    limb = _limb(markers, landmarks, side, ARM, shoulder, body, is_arm, faces)
    if limb:
        _keep_better(markers, limb, limb.posed(_end(skin, -from_tip), is_stretched=True))


def _arm(body, shoulder, across):
    """(which samples (s,) bool are of the arm, how far these are from its tip, along the skin); none if it is short."""
    # From the middle of the mesh, not from the marker: an alignment may be a little to one side.
    aside = _level(across)
    out = body.points @ aside
    out -= np.median(out[body.above > 0.5]) + 0.5 * np.linalg.norm(across)
    shoulder = shoulder + ((body.points - shoulder) @ aside - out)[0] * aside
    beyond = np.flatnonzero((out > BEYOND * body.height) & (body.above > HANDS))
    points, reach, is_arm = body.points[beyond], REACH * body.height, np.zeros(len(body.points), bool)
    far = _along_from(np.linalg.norm(points - shoulder, axis=1) < ROOT * body.height, points, reach)
    far[np.isinf(far)] = 0.0
    if not far.any() or far.max() < LEAST_ARM * body.height:
        return is_arm, far[:0]
    # Flanks may be as far from the shoulder along the skin, but not as far out.
    tip = (far + out[beyond]).argmax()
    from_tip = _along_from(np.arange(len(points)) == tip, points, reach)
    near = from_tip < far[tip]
    is_arm[beyond[near]] = True
    return is_arm, from_tip[near]


def _along_from(seeds, points, reach):
    """(n,): lengths of the shortest ways from points (n, 3) where seeds (n,) is true, by steps of at most `reach` from
    one point to another; infinite where there is none."""
    squares = (points**2).sum(axis=1)
    apart = squares[:, None] - 2.0 * points @ points.T + squares
    steps = np.where(apart < reach**2, np.sqrt(np.maximum(apart, 0.0)), np.inf)
    found = np.where(seeds, 0.0, np.inf)
    left = found.copy()
    while left.min(initial=np.inf) < np.inf:  # Dijkstra
        nearest = left.argmin()
        left[nearest] = np.inf
        ways = found[nearest] + steps[nearest]
        is_nearer = ways < found
        found[is_nearer] = left[is_nearer] = ways[is_nearer]
    return found


def _pose_leg(markers, landmarks, side, hip, body, is_leg, faces, ahead):
    """Turns the markers of one leg, then of its foot, where they lie better then. ahead (3,): where the feet point."""
    skin = body.points[is_leg]
    limb = _limb(markers, landmarks, side, LEG, hip, body, is_leg, faces)
    if limb:
        foot, ankle = (_numbers(landmarks, side, names) for names in FOOT)
        is_bent, is_up = limb.is_bent(), not (foot and ankle and markers[foot, 2].mean() < markers[ankle, 2].mean())
        toes, heel = (markers[_numbers(landmarks, side, (name,))] for name in ("toe", "heel"))
        points = toes.mean(axis=0) - heel.mean(axis=0) if len(toes) and len(heel) else 0.0 * ahead
        _keep_better(markers, limb, limb.posed(_end(skin, -skin[:, 2]), is_bent, np.stack([points, ahead])))
        if not is_up:
            markers[foot] = limb.foot(markers, foot, ankle)
            if is_bent:  # stretched it stands; how long it is then is told by no skin
                above = heights_of([landmarks[k] for k in foot]).mean() * body.height
                markers[limb.numbers, 2] += body.ground + above - markers[foot, 2].mean()


def _limb(markers, landmarks, side, parts, joint, body, is_limb, faces):
    """The `Limb`, or None where markers or skin tell too little."""
    upper, fore, middle = (_numbers(landmarks, side, names) for names in (*parts[:2], parts[2:]))
    if not middle or np.count_nonzero(is_limb) < 20:
        return None
    skin, end = (body.points[is_limb], body.normals[is_limb]), [k for k in fore if landmarks[k].startswith("ankle")]
    return Limb(markers, joint, upper, fore, middle, *skin, faces, body.height, end)


def _end(skin, outermost):
    return skin[outermost >= np.quantile(outermost, 0.95)].mean(axis=0)


def _keep_better(markers, limb, posed):
    if limb.residual(posed) < BETTER * limb.residual(markers):
        markers[limb.numbers] = posed[limb.numbers]


def _numbers(landmarks, side, names):
    return [number for number, name in enumerate(landmarks) if side_of(name) == side and name.split(".")[0] in names]


def _level(way):
    return unit(way * [1.0, 1.0, 0.0])
