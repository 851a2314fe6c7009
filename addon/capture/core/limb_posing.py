# SPDX-License-Identifier: GPL-3.0-or-later
"""Arms and legs of a reference frame brought into the pose of the mesh: hardly anybody stands as the mesh does."""

import numpy as np

from ...scene.core.motion import unit
from . import facing, proportions
from .landmarks import heights_of, side_of
from .limb import Limb
from .proportions import hips_of

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

    Arms are stretched out, and legs whose knee is bent. Each limb is tried in all directions about that of the end of
    its skin, and rolled about that; the best one is refined by ICP, first the whole limb, then what is beyond elbow or
    knee. Markers look for skin that looks their way (facing.py), joints for the middle of the limb. Only skin beyond
    the shoulder is an arm's: arms of a mesh that lie at its sides are not followed. A limb that would not lie much
    nearer to its skin is left alone. Where legs are unusual, markers go to their heights first (proportions.py).

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
            _pose_leg(result, landmarks, side, hips[number], body, is_leg, faces)
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


def _pose_leg(markers, landmarks, side, hip, body, is_leg, faces):
    """Turns the markers of one leg, then of its foot, where they lie better then."""
    skin = body.points[is_leg]
    limb = _limb(markers, landmarks, side, LEG, hip, body, is_leg, faces)
    if limb:
        foot, ankle = (_numbers(landmarks, side, names) for names in FOOT)
        captured = markers.copy()
        is_bent = limb.is_bent()
        _keep_better(markers, limb, limb.posed(_end(skin, -skin[:, 2]), is_stretched=is_bent))
        if foot and ankle and captured[foot, 2].mean() < captured[ankle, 2].mean():  # else the leg is held up
            markers[foot] = limb.foot(captured, markers, foot, ankle)
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
