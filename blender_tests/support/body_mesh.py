# SPDX-License-Identifier: GPL-3.0-or-later
"""A simple body for the walking figure: a capsule around each bone. Made in no time; figure_body has a smooth one."""

import numpy as np

from . import figure_body, rings, walking_figure

#: bone: (joint it hangs on, from and to in the T-pose from that joint, of the left side, radii across: to the side of
#: the bone and to the front); on thighs and shanks Z is a share of the bone's length.
CENTRE = {
    "pelvis": ("pelvis", (0.0, 0.0, -0.04), (0.0, 0.0, 0.10), (0.165, 0.125)),
    "chest": ("chest", (0.0, 0.0, -0.02), (0.0, 0.0, 0.28), (0.15, 0.115)),
    "neck": ("chest", (0.0, 0.01, 0.33), (0.0, 0.0, 0.45), (0.055, 0.055)),
    "head": ("head", (0.0, 0.0, 0.08), (0.0, 0.0, 0.14), (0.078, 0.098)),
}
SIDES = {
    "upper_arm": ("shoulder", (0.0, 0.0, 0.0), (0.28, 0.0, 0.0), (0.045, 0.045)),
    "forearm": ("elbow", (0.0, 0.0, 0.0), (0.25, 0.0, 0.0), (0.036, 0.036)),
    "hand": ("wrist", (0.02, 0.0, 0.0), (0.14, 0.0, 0.0), (0.022, 0.04)),
    "thigh": ("hip", (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.07, 0.075)),
    "shank": ("knee", (0.0, 0.0, 0.0), (0.0, 0.0, -0.92), (0.048, 0.052)),
    "foot": ("ankle", (0.0, 0.03, -0.045), (0.0, -0.135, -0.05), (0.042, 0.032)),
}
#: Bones that turn with another one.
TURNS_WITH = {"neck": "chest", "hand.L": "forearm.L", "hand.R": "forearm.R"}


def body(legs=1.0, around=14, along=8):
    """(vertices (n, 3) float64, triangles (t, 3) int, bones (n,) names): the figure's T-pose, on z = 0, facing -Y."""
    joints, _ = walking_figure.upright(1, legs)
    parts = [(bone, *_ends(joints, place)) for bone, place in CENTRE.items()]
    for side, sign in (("L", 1.0), ("R", -1.0)):
        for bone, (joint, begin, end, radii) in SIDES.items():
            stretch = {"thigh": walking_figure.THIGH * legs, "shank": walking_figure.SHANK * legs}.get(bone, 1.0)
            scale = np.array([sign, 1.0, stretch])
            place = (f"{joint}.{side}", begin * scale, end * scale, radii)
            parts.append((f"{bone}.{side}", *_ends(joints, place)))
    vertices, triangles, bones, count = [], [], [], 0
    for bone, begin, end, radii in parts:
        points, faces = capsule(begin, end, radii, around, along)
        vertices.append(points)
        triangles.append(faces + count)
        bones += [bone] * len(points)
        count += len(points)
    return np.concatenate(vertices), np.concatenate(triangles), np.array(bones)


def posed(vertices, bones, time, legs=1.0):
    """(f, n, 3): vertices of `body()` moved rigidly with their bones, at the times (f,) of the walk."""
    names = [TURNS_WITH.get(bone, bone) for bone in bones]
    weights = np.array([[float(name == bone) for bone in figure_body.BONES] for name in names])
    joints, turns, _ = walking_figure.walking(time, legs)
    return figure_body.posed(figure_body.Body(vertices, None, weights, legs), joints, turns)


def capsule(begin, end, radii, around, along):
    """Vertices and triangles of a closed tube with round ends from `begin` to `end`, elliptic: radii (side, front)."""
    begin, end = np.asarray(begin, float), np.asarray(end, float)
    axis = (end - begin) / np.linalg.norm(end - begin)
    front = np.array([0.0, 1.0, 0.0]) if abs(axis[1]) < 0.9 else np.array([0.0, 0.0, 1.0])
    front -= (front @ axis) * axis
    front /= np.linalg.norm(front)
    side = np.cross(front, axis)
    angles = np.linspace(0.0, np.pi / 2.0, 4)[1:]
    cap = min(radii)
    circles = [(begin - cap * np.cos(a) * axis, np.sin(a)) for a in angles]
    circles += [(begin + share * (end - begin), 1.0) for share in np.linspace(0.0, 1.0, along)[1:-1]]
    circles += [(end + cap * np.cos(a) * axis, np.sin(a)) for a in angles[::-1]]
    turn = 2.0 * np.pi * np.arange(around) / around
    circle = radii[0] * np.cos(turn)[:, None] * side + radii[1] * np.sin(turn)[:, None] * front
    points = np.concatenate([centre + size * circle for centre, size in circles])
    sides = rings.triangles(rings.quads(len(circles), around))
    bottom, top = np.arange(around), np.arange(-around, 0) + len(points)
    ends = rings.fan(len(points), bottom)[:, ::-1], rings.fan(len(points) + 1, top)
    faces = np.concatenate([sides, *ends])
    points = np.concatenate([points, [begin - cap * axis, end + cap * axis]])
    corners = points[faces]
    volume = np.einsum("ti,ti->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    return points, (faces if volume > 0.0 else faces[:, ::-1])


def _ends(joints, place):
    joint, begin, end, radii = place
    return joints[joint][0] + np.asarray(begin), joints[joint][0] + np.asarray(end), radii
