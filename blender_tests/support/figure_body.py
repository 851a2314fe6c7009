# SPDX-License-Identifier: GPL-3.0-or-later
"""A smooth closed body for the walking figure, and how it goes along with the bones. Needs numpy alone.

The surface is where the distance to a set of round cones, smoothly united, is zero: one connected mesh of quads with
feet, mittens and a head, and with its thighs apart. `posed()` turns it by blended bones: what a well made rig would
show, to compare with.
"""

import functools
from dataclasses import dataclass

import numpy as np

from . import quad_surface, walking_figure

#: How far parts melt into each other, and how far from a joint bones share the skin, in metres.
MELT, SHARE = 0.014, 0.016

#: How far the cones of these bones do.
INNER_MELT = {"pelvis": 0.022, "chest": 0.022, "head": 0.014}
INNER_MELT |= {f"{bone}.{side}": 0.006 for bone in ("foot", "toe") for side in "LR"}

#: bone: (joint, cones); a cone: from, to (from that joint, in the T-pose, of the left side), radii there, and how much
#: wider it is along X, Y, Z. On thighs and shanks Z is a share of the bone.
CENTRE = {
    "pelvis": (
        "pelvis",
        (
            ((-0.055, 0.0, 0.025), (0.055, 0.0, 0.025), (0.09, 0.09), (1, 1.06, 1.1)),
            ((0.0, 0.0, 0.05), (0.0, 0.0, 0.14), (0.09, 0.078), (1.38, 1, 1)),
            ((-0.065, 0.045, -0.03), (-0.065, 0.03, -0.05), (0.06, 0.056), (1, 1, 1)),
            ((0.065, 0.045, -0.03), (0.065, 0.03, -0.05), (0.06, 0.056), (1, 1, 1)),
        ),
    ),
    "chest": (
        "chest",
        (
            ((0.0, 0.0, -0.05), (0.0, 0.0, 0.06), (0.072, 0.085), (1.4, 1, 1)),
            ((0.0, 0.002, 0.05), (0.0, 0.004, 0.19), (0.084, 0.1), (1.47, 1.12, 1)),
            ((-0.1, 0.008, 0.26), (0.1, 0.008, 0.26), (0.056, 0.056), (1, 1.05, 1)),
            ((0.02, 0.02, 0.37), (0.15, 0.008, 0.3), (0.03, 0.036), (1, 1, 1)),
            ((-0.02, 0.02, 0.37), (-0.15, 0.008, 0.3), (0.03, 0.036), (1, 1, 1)),
            ((0.0, 0.02, 0.32), (0.0, 0.008, 0.42), (0.046, 0.042), (1, 1, 1)),
        ),
    ),
    "head": (
        "head",
        (
            ((0.0, 0.015, -0.03), (0.0, 0.008, 0.04), (0.04, 0.042), (1, 1, 1)),
            ((0.0, 0.008, 0.115), (0.0, 0.008, 0.158), (0.066, 0.07), (1, 1.25, 1)),
            ((0.0, -0.03, 0.02), (0.0, -0.03, 0.1), (0.036, 0.05), (1, 1, 1)),
            ((0.0, -0.082, 0.085), (0.0, -0.074, 0.125), (0.017, 0.01), (1, 1, 1)),
        ),
    ),
}
SIDES = {
    "upper_arm": (
        "shoulder",
        (
            ((0.0, 0.0, 0.0), (0.12, 0.0, 0.0), (0.046, 0.043), (1, 1, 1)),
            ((0.12, 0.0, 0.0), (0.28, 0.0, 0.0), (0.043, 0.032), (1, 1, 1)),
        ),
    ),
    "forearm": (
        "elbow",
        (
            ((0.0, 0.0, 0.0), (0.08, 0.0, 0.0), (0.032, 0.036), (1, 1, 1)),
            ((0.08, 0.0, 0.0), (0.26, 0.0, 0.0), (0.036, 0.023), (1, 1.1, 1)),
            ((0.27, 0.0, 0.0), (0.365, -0.004, 0.0), (0.016, 0.015), (1, 2.3, 1)),
        ),
    ),
    "thigh": (
        "hip",
        (
            ((0.005, 0.0, 0.0), (0.005, 0.0, -0.5), (0.08, 0.072), (1, 1.04, 1)),
            ((0.005, 0.0, -0.5), (0.0, 0.0, -1.0), (0.072, 0.047), (1, 1.04, 1)),
        ),
    ),
    "shank": (
        "knee",
        (
            ((0.0, 0.0, 0.0), (0.0, 0.014, -0.3), (0.045, 0.05), (1, 1, 1)),
            ((0.0, 0.014, -0.3), (0.0, 0.008, -0.97), (0.05, 0.033), (1, 1, 1)),
        ),
    ),
    "foot": (
        "ankle",
        (
            ((0.0, 0.014, -0.04), (-0.01, -0.095, -0.052), (0.04, 0.033), (1, 1, 1)),
            ((0.0, 0.014, -0.04), (0.014, -0.09, -0.054), (0.04, 0.032), (1, 1, 1)),
        ),
    ),
    "toe": (
        "toe",
        (
            ((-0.011, 0.0, 0.027), (-0.012, -0.016, 0.026), (0.033, 0.031), (1, 1, 1)),
            ((0.015, 0.006, 0.026), (0.016, -0.004, 0.025), (0.032, 0.03), (1, 1, 1)),
        ),
    ),
}
NEXT = {
    "pelvis": ("chest", "thigh.L", "thigh.R"),
    "chest": ("pelvis", "head", "upper_arm.L", "upper_arm.R"),
    "head": ("chest",),
    **{f"upper_arm.{side}": ("chest", f"forearm.{side}") for side in "LR"},
    **{f"forearm.{side}": (f"upper_arm.{side}",) for side in "LR"},
    **{f"thigh.{side}": ("pelvis", f"shank.{side}") for side in "LR"},
    **{f"shank.{side}": (f"thigh.{side}", f"foot.{side}") for side in "LR"},
    **{f"foot.{side}": (f"shank.{side}", f"toe.{side}") for side in "LR"},
    **{f"toe.{side}": (f"foot.{side}",) for side in "LR"},
}
BONES = tuple(NEXT)


@dataclass(frozen=True, eq=False)
class Body:
    """vertices (n, 3) of the T-pose on z = 0, facing -Y; quads (q, 4); weights (n, len(BONES)), rows sum to 1."""

    vertices: np.ndarray
    quads: np.ndarray
    weights: np.ndarray
    legs: float


@functools.lru_cache(maxsize=4)
def body(legs=1.0, spacing=0.0155):
    """The Body with an edge length of about `spacing` metres."""
    cones = _cones(legs)

    def distance(points):
        return _united(points, cones).min(axis=1)

    def field(points):
        return np.maximum(_melted(_united(points, cones), MELT), -points[:, 2])  # soles are flat

    high = np.array([0.88, 0.18, walking_figure.HEIGHT - (1.0 - legs) * 0.85 + 0.03])
    low = np.array([-spacing * (np.ceil(high[0] / spacing) - 0.5), -0.21, -0.02])  # both sides alike
    vertices, quads = quad_surface.of_field(field, low, high, spacing, near=lambda points: distance(points) < 0.06)
    return Body(vertices, quads, _weights(_united(vertices, cones)), legs)


def posed(shape, joints, turns):
    """(f, n, 3): a Body where the bones are; joints: name -> (f, 3), turns: bone -> (f, 3, 3), of walking_figure."""
    rest, _ = walking_figure.upright(1, shape.legs)
    frames = len(joints["pelvis"])
    result = np.zeros((frames, *shape.vertices.shape))
    for column, bone in enumerate(BONES):
        part = np.flatnonzero(shape.weights[:, column])
        joint = _joint(bone)
        local = shape.vertices[part] - rest[joint][0]
        moved = joints[joint][:, None] + np.einsum("fij,kj->fki", turns[bone], local)
        result[:, part] += shape.weights[part, column, None] * moved
    return result


def _joint(bone):
    name, _, side = bone.partition(".")
    return CENTRE[name][0] if name in CENTRE else f"{SIDES[name][0]}.{side}"


def _cones(legs):
    """{bone: [(begin, end, radii, widths)]} in the T-pose."""
    joints, _ = walking_figure.upright(1, legs)
    stretch = {"thigh": walking_figure.THIGH * legs, "shank": walking_figure.SHANK * legs}
    result = {}
    for bone in BONES:
        name, _, side = bone.partition(".")
        scale = np.array([-1.0 if side == "R" else 1.0, 1.0, stretch.get(name, 1.0)])
        centre = joints[_joint(bone)][0]
        cones = (CENTRE.get(name) or SIDES[name])[1]
        result[bone] = [
            (centre + begin * scale, centre + end * scale, radii, np.array(widths, float))
            for begin, end, radii, widths in cones
        ]
    return result


def _united(points, cones):
    """(n, len(BONES)): the distance to each bone's cones, near enough to the true one near the surface."""
    columns = []
    for bone in BONES:
        inside = []
        for begin, end, radii, widths in cones[bone]:
            axis, away = (end - begin) / widths, (points - begin) / widths
            share = np.clip(away @ axis / (axis @ axis), 0.0, 1.0)
            off = np.linalg.norm(away - share[:, None] * axis, axis=1)
            inside.append(off - (radii[0] + share * (radii[1] - radii[0])))
        columns.append(_melted(np.stack(inside, axis=1), INNER_MELT.get(bone, 0.002)))
    return np.stack(columns, axis=1)


def _melted(distances, reach):
    """(n,): the least of distances (n, k), rounded where two are alike."""
    least = distances.min(axis=1)
    return least - reach * np.log(np.exp((least[:, None] - distances) / reach).sum(axis=1))


def _weights(distances):
    """(n, len(BONES)): the nearest bone and those next to it share the skin around their joint."""
    first = distances.argmin(axis=1)
    joined = np.eye(len(BONES), dtype=bool)
    for bone, others in NEXT.items():
        for other in others:
            joined[BONES.index(bone), BONES.index(other)] = True
    weights = np.exp(-(distances - distances.min(axis=1, keepdims=True)) / SHARE) * joined[first]
    weights[weights < 1e-3] = 0.0
    return weights / weights.sum(axis=1, keepdims=True)
