# SPDX-License-Identifier: GPL-3.0-or-later
"""How feet stand and knees bend on the mesh, against the capture that moved it. No bpy."""

import numpy as np

from addon.capture.core import marker_sets, readers
from addon.capture.core.landmarks import feet
from addon.capture.core.proportions import with_hips
from addon.capture.core.soles import find_stances
from addon.scene.core.motion import fit_rotations

from .measures import share, slide

RATE_HZ = 100.0
#: Of feet that stand, body heights a second.
SLOW = 0.09
#: Over the body's height: what is sole, above the ground and away from the anchors of the foot.
SOLE, AROUND = 0.012, 0.07
#: Over the knee's height above the ground, which tells how long the legs are: stretches of thigh above the knee and of
#: shank below it, and how far from the knee sideways.
THIGH, SHANK, ASIDE = (0.18, 0.5), (-0.5, -0.18), 0.26
#: Meters along an arm that is stretched out to its side, from the elbow outward; and how far from it sideways.
UPPER_ARM, FOREARM, ACROSS = (-0.2, -0.05), (0.05, 0.2), 0.08


def rows(subject, carried):
    """[(what, figure in words)]: slide of soles while the capture's feet stand, and knees off the capture's."""
    landmarks = marker_sets.recognise(carried.names).landmarks
    result = []
    stances = flat_stances(subject, carried, landmarks)
    if stances:
        moved = slide(carried.shapes, [(begin, end, sole) for begin, end, sole, _ in stances])
        own = slide(carried.balls, [(begin, end, markers) for begin, end, _, markers in stances])
        words = f"{share(moved, subject.height)} in {len(stances)} stances; "
        words += f"the markers there {share(own, subject.height)}"
        result.append(("slide while feet stand", words))
    knees = {side: (on_mesh(subject, carried, landmarks, side), in_capture(subject, carried, landmarks, side))
             for side in "LR"}  # fmt: skip
    off = [mesh - capture for mesh, capture in knees.values() if mesh is not None and capture is not None]
    if off:
        off = np.concatenate(off)
        off = off[~np.isnan(off)]
        words = f"rms {np.sqrt((off**2).mean()):.1f}, at most {np.abs(off).max():.1f} degrees"
        bent = np.nanmax([capture for _, capture in knees.values()])
        result.append(("knees off the capture's", f"{words}, where they bend by up to {bent:.0f}"))
    elbows = elbows_off(subject, carried, landmarks) if subject.truth is not None else np.zeros(0)
    if len(elbows):
        words = f"rms {np.sqrt((elbows**2).mean()):.1f}, at most {np.abs(elbows).max():.1f} degrees"
        result.append(("elbows off the skinned figure's", words))
    return result


def elbows_off(subject, carried, landmarks):
    """(2 f,) degrees that elbows of the mesh are bent more than those of the skinned figure, whose arms are stretched
    out at rest."""
    result, rest = [np.zeros(0)], subject.vertices
    for elbow in (k for k, name in enumerate(landmarks) if name in ("elbow.L", "elbow.R")):
        away = rest - rest[carried.anchors[elbow]]
        out, is_arm = away[:, 0] * np.sign(rest[carried.anchors[elbow], 0]), np.abs(away[:, 2]) < ACROSS
        parts = [np.flatnonzero(is_arm & (out > low) & (out < high)) for low, high in (UPPER_ARM, FOREARM)]
        bends = [bend(*(fit_rotations(rest[part], shapes[:, part])[..., [1, 2, 0]] for part in parts))
                 for shapes in (carried.shapes, subject.truth)]  # fmt: skip
        result.append(bends[0] - bends[1])
    return np.concatenate(result)


def flat_stances(subject, carried, landmarks):
    """[(begin, end, vertices of the sole, markers of the foot)] while heel and toes of the capture both stand."""
    result, rest, height = [], subject.vertices, subject.height
    both = feet(landmarks)
    away = {side: np.linalg.norm(rest[:, None, :2] - rest[carried.anchors[markers]][None, :, :2], axis=2).min(axis=1)
            for side, markers in both.items() if markers}  # fmt: skip
    nearest = np.min(list(away.values()), axis=0) if away else None  # what is near both is the nearer foot's
    is_low = rest[:, 2] - rest[:, 2].min() < SOLE * height
    for side, markers in both.items():
        heel = [k for k in markers if landmarks[k].startswith("heel")]
        toe = [k for k in markers if k not in heel]
        if not heel or not toe:
            continue
        sole = np.flatnonzero(is_low & (away[side] < AROUND * height) & (away[side] == nearest))
        stands = [find_stances(carried.balls[:, some], RATE_HZ, height, SLOW) for some in (heel, toe)]
        flat = np.concatenate([[False], stands[0].any(axis=1) & stands[1].any(axis=1), [False]])
        ends = np.flatnonzero(np.diff(flat.astype(int)))
        result += [(begin, end, sole, markers) for begin, end in zip(ends[::2], ends[1::2], strict=True)]
    return result


def on_mesh(subject, carried, landmarks, side):
    """(f,) degrees that the knee of the mesh is bent more than at rest; None without a knee."""
    knees = [k for k, name in enumerate(landmarks) if name in (f"knee.{side}", f"knee.joint.{side}")]
    if not knees:
        return None
    rest = subject.vertices
    knee = rest[carried.anchors[knees[0]]]
    height = knee[2] - rest[:, 2].min()
    is_leg = np.linalg.norm((rest - knee)[:, :2], axis=1) < ASIDE * height
    above = (rest[:, 2] - knee[2]) / height
    parts = [np.flatnonzero(is_leg & (above > low) & (above < high)) for low, high in (THIGH, SHANK)]
    return bend(*(fit_rotations(rest[part], carried.shapes[:, part]) for part in parts))


def in_capture(subject, carried, landmarks, side):
    """(f,) degrees that thigh and shank of the capture are bent more than in the standing take."""
    standing = readers.read(subject.standing)
    middle = standing.positions[standing.frames // 2]
    places = dict(zip(standing.labels, middle, strict=True))
    reference = np.array([places.get(name, np.full(3, np.nan)) for name in carried.names])
    known = ~np.isnan(reference[:, 0])
    names = [name for name, is_known in zip(landmarks, known, strict=True) if is_known]
    reference, moving, names = with_hips(reference[known], carried.captured[:, known], names)
    turns = []
    for wanted in (("hip", "thigh", "knee"), ("knee", "shank", "ankle")):
        part = [k for k, name in enumerate(names) if name and name.split(".")[0] in wanted and name.endswith(side)]
        if len(part) < 3:
            return None
        found = fit_rotations(reference[part], moving[:, part])
        found[np.isnan(moving[:, part, 0]).any(axis=1)] = np.nan
        turns.append(found)
    return bend(*turns)


def bend(thigh, shank):
    """(f,) degrees between where both turn what is along their last axis at rest, (f, 3, 3) each."""
    return np.degrees(np.arccos(np.clip((thigh[..., 2] * shank[..., 2]).sum(axis=-1), -1.0, 1.0)))
