# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies whose legs are a larger or smaller share of them than those of grown-ups: markers at the heights of such.
And the centres of the hips, which no marker can be put on: legs turn about them."""

import numpy as np

from ...scene.core.motion import fit_rotations, unit
from .landmarks import ARM, segments_of, side_of

#: Height of the crotch of grown-ups over that of the body (Drillis and Contini 1966), and from what difference on a
#: mesh is another kind of body; twice the standard deviation among people.
CROTCH, UNUSUAL = 0.465, 0.03
#: Where to look for it, over the body's height: between, so near to the middle, on skin that looks down so steeply.
BETWEEN, NEAR, DOWN, LEAST = (0.2, 0.7), 0.012, -0.3, 5


def crotch_of(body):
    """Height of the crotch of a Body over its own; CROTCH where that is usual or nothing looks down between legs
    (skirts)."""
    upper = body.skin[body.above > 0.5, :2]
    middle = np.median(upper, axis=0)
    # Legs are beside each other along the axis that the upper body is wider in.
    _, _, axes = np.linalg.svd(upper - middle, full_matrices=False)
    is_near = np.abs((body.skin[:, :2] - middle) @ axes[0]) < NEAR * body.height
    is_between = (body.above > BETWEEN[0]) & (body.above < BETWEEN[1])
    found = body.above[is_near & is_between & (body.normals[:, 2] < DOWN)]
    crotch = float(np.quantile(found, 0.2)) if len(found) >= LEAST else CROTCH
    return CROTCH if abs(crotch - CROTCH) < UNUSUAL else crotch


def moved(markers, landmarks, body, before, after):
    """(m, 3): markers (m, 3), aligned with the Body, of one whose crotch is at `before` of the height, as high as of
    one who has it at `after`; arms go along with their shoulder. landmarks  m names or None."""
    if before == after:
        return markers
    above = (markers[:, 2] - body.ground) / body.height
    above = np.where(above < before, above / before * after, 1.0 - (1.0 - above) / (1.0 - before) * (1.0 - after))
    result = markers.copy()
    result[:, 2] = body.ground + body.height * above
    for side in "LR":
        on_side = [k for k, name in enumerate(landmarks) if side_of(name) == side]
        shoulder, arm = ([k for k in on_side if landmarks[k].split(".")[0] in names] for names in (("shoulder",), ARM))
        if shoulder and arm:
            result[arm, 2] = markers[arm, 2] + (result - markers)[shoulder, 2].mean()
    return result


HIPS, FRONT = ("hip.L", "hip.R"), ("pelvis.front.L", "pelvis.front.R")
#: By how much hips as below are off, along an axis, over the distance of both (Leardini et al. 1999); rounds.
BELL, ROUNDS = 0.083, 3


def hips_of(points, landmarks):
    """(2, 3) left and right of markers (m, 3), or (0, 3) where they do not tell.

    Those of a skeleton; else where Bell, Petersen and Brand (1990) found them from the width of the pelvis: 0.36 of it
    to the side of the middle of the anterior spines, 0.22 back and 0.30 down. Needs both of these and something at the
    pelvis' back. landmarks  m names or None.
    """
    if set(HIPS) <= set(landmarks):
        return points[[landmarks.index(name) for name in HIPS]]
    back = [k for k, landmark in enumerate(landmarks) if (landmark or "").startswith("pelvis.back")]
    if not {*FRONT} <= {*landmarks} or not back:
        return np.zeros((0, 3))
    front = points[[landmarks.index(name) for name in FRONT]]
    middle, across = front.mean(axis=0), front[0] - front[1]
    width, left = np.linalg.norm(across), unit(across)
    backward = points[back].mean(axis=0) - middle
    backward = unit(backward - (backward @ left) * left)
    down = np.cross(backward, left)
    return np.array([middle + width * (sign * 0.36 * left + 0.22 * backward + 0.30 * down) for sign in (1.0, -1.0)])


def with_hips(reference, markers, landmarks):
    """(reference (m, 3), markers (f, m, 3), landmarks), each with the two hips appended, which move rigidly with the
    markers of the pelvis; unchanged where these do not tell, and of skeletons.

    A hip is where the markers of its thigh turn about, as far as they tell that better than the pelvis does.
    """
    hips = hips_of(reference, landmarks)
    if len(hips) == 0 or "hip.L" in landmarks:
        return reference, markers, tuple(landmarks)
    pelvis = [k for k, landmark in enumerate(landmarks) if (landmark or "").startswith("pelvis.")]
    usual = BELL * max(np.linalg.norm(hips[0] - hips[1]), 1e-12)
    turns = fit_rotations(reference[pelvis], markers[:, pelvis])
    turns[(~np.isnan(markers[:, pelvis, 0])).sum(axis=1) < 3] = np.nan
    moved = carried(np.concatenate([reference[pelvis], hips]), markers[:, pelvis], turns)[:, len(pelvis) :]
    for hip, name in enumerate(HIPS):
        thigh = [k for k, landmark in enumerate(landmarks) if f"thigh.{name[-1]}" in segments_of(landmark)]
        paths = np.einsum("fji,fkj->kfi", turns, markers[:, thigh] - moved[:, hip, None])  # as the pelvis sees them
        off = _middle(paths, usual)
        hips[hip], moved[:, hip] = hips[hip] + off, moved[:, hip] + turns @ off
    return np.concatenate([reference, hips]), np.concatenate([markers, moved], axis=1), (*landmarks, *HIPS)


def _middle(paths, usual):
    """(3,): the point that each of paths (k, f, 3) is as far from all the time (linear in it), NaN left out.

    It is the likeliest one where the origin is off by `usual` along each axis, and skin slides by what is left of each
    distance: by as much all through a motion, so that more frames tell no more.
    """
    normal, right, square = np.zeros((3, 3)), np.zeros(3), 1e-12
    for path in paths:
        path = path[~np.isnan(path[:, 0])]
        far = np.linalg.norm(path, axis=1)
        if far.any():
            ways, levels = (path - path.mean(axis=0)) / far.mean(), 0.5 * (far**2 - (far**2).mean()) / far.mean()
            normal, right = normal + ways.T @ ways / len(path), right + ways.T @ levels / len(path)
            square += (levels**2).mean()
    result, slides = np.zeros(3), 1e-9 * square
    for _ in range(ROUNDS):
        result = np.linalg.solve(normal + slides / max(len(paths), 1) / usual**2 * np.eye(3), right)
        slides = square - 2.0 * right @ result + result @ normal @ result
    return result


def carried(reference, markers, turns):
    """(f, k, 3): where points (k, 3) are that move rigidly with the first of them, of which markers (f, j, 3) are where
    they were seen; NaN in frames without any. turns  (f, 3, 3) of that motion."""
    known = ~np.isnan(markers[..., 0])
    shares = known / np.maximum(known.sum(axis=1, keepdims=True), 1)
    centres = np.einsum("fj,fji->fi", shares, np.nan_to_num(markers))
    offsets = reference - (shares @ reference[: markers.shape[1]])[:, None]
    result = centres[:, None] + np.einsum("fij,fkj->fki", turns, offsets)
    result[~known.any(axis=1)] = np.nan
    return result
