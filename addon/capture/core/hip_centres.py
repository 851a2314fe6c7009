# SPDX-License-Identifier: GPL-3.0-or-later
"""The centres of the hips, which no marker can be put on: legs turn about them."""

import numpy as np

from ...scene.core.rigid import fit_rotations
from .landmarks import side_of

HIPS = ("hip.L", "hip.R")


def with_hips(reference, character, markers, landmarks):
    """(reference, character, markers, landmarks), each with the two hips appended; unchanged where that can't be.

    Hips are where Bell, Petersen and Brand (1990) found them from the width of the pelvis: 0.36 of it to the side of
    the middle of the anterior spines, 0.22 back and 0.30 down. In `markers` they move rigidly with those of the pelvis.

    reference, character  (m, 3); markers  (f, m, 3); landmarks  m names or None. Needs both anterior spines and
    something at the pelvis' back, in reference and character.
    """
    of_reference, of_character = (_hips(points, landmarks) for points in (reference, character))
    if of_reference is None or of_character is None or "hip.L" in landmarks:
        return reference, character, markers, tuple(landmarks)
    pelvis = [k for k, landmark in enumerate(landmarks) if (landmark or "").startswith("pelvis.")]
    known = ~np.isnan(markers[:, pelvis, 0])
    turns = fit_rotations(reference[pelvis], markers[:, pelvis])
    shares = known / np.maximum(known.sum(axis=1, keepdims=True), 1)
    centres = (shares[..., None] * np.where(known[..., None], markers[:, pelvis], 0.0)).sum(axis=1)
    rest_centres = shares @ reference[pelvis]
    hips = centres[:, None] + np.einsum("fij,fkj->fki", turns, of_reference - rest_centres[:, None])
    hips[known.sum(axis=1) < 3] = np.nan
    return (
        np.concatenate([reference, of_reference]),
        np.concatenate([character, of_character]),
        np.concatenate([markers, hips], axis=1),
        (*landmarks, *HIPS),
    )


def _hips(points, landmarks):
    """(2, 3) left and right, or None."""
    front, back = {}, []
    for point, landmark in zip(points, landmarks, strict=True):
        if landmark and not np.isnan(point).any():
            if landmark.startswith("pelvis.front"):
                front[side_of(landmark)] = point
            elif landmark.startswith("pelvis.back"):
                back.append(point)
    if "L" not in front or "R" not in front or not back:
        return None
    middle, left = 0.5 * (front["L"] + front["R"]), front["L"] - front["R"]
    width = np.linalg.norm(left)
    left = left / max(width, 1e-12)
    backward = np.mean(back, axis=0) - middle
    backward -= (backward @ left) * left
    backward /= max(np.linalg.norm(backward), 1e-12)
    down = np.cross(backward, left)
    if not width > 0.0:
        return None
    return np.array([middle + width * (sign * 0.36 * left + 0.22 * backward + 0.30 * down) for sign in (1.0, -1.0)])
