# SPDX-License-Identifier: GPL-3.0-or-later
"""The project's own figure as a body with bones and skin weights."""

from dataclasses import dataclass

import numpy as np
from support import figure_body, walking_figure


@dataclass(frozen=True, eq=False)
class Figure:
    """vertices (n, 3), Z up, and polygons

    bones    {name: (head, tail, name of the parent or None)}, parents first
    weights  {bone: (indices, weights)}
    arm      (shoulder, elbow): joints
    turns    ((bone, axis, degrees), ...) in the world, in their order
    """

    vertices: np.ndarray
    polygons: object
    bones: dict
    weights: dict
    arm: tuple
    turns: tuple


def walker(spacing=0.0125):
    """The figure of the walking demo, in its T-pose; spacing: metres between vertices."""
    body = figure_body.body(spacing=spacing)
    joints, _ = walking_figure.upright(1, body.legs)
    at = {name: place[0] for name, place in joints.items()}
    ends = {"pelvis": "chest", "chest": "neck"}
    ends |= {"upper_arm": "elbow", "forearm": "wrist", "thigh": "knee", "shank": "ankle"}
    heads = {"upper_arm": "shoulder", "forearm": "elbow", "thigh": "hip", "shank": "knee", "foot": "ankle"}
    parents = {"chest": "pelvis", "head": "chest", "upper_arm": "chest", "forearm": "upper_arm", "thigh": "pelvis"}
    parents |= {"shank": "thigh", "foot": "shank", "toe": "foot"}
    bones = {}
    for bone in figure_body.BONES:
        name, dot, side = bone.partition(".")
        head = at[heads.get(name, name) + dot + side]
        end = ends.get(name)
        tail = at.get(f"{end}{dot}{side}", at.get(end)) if end else head + np.array((0.0, -0.1, 0.0))
        parent = parents.get(name)
        sided = parent in {"upper_arm", "thigh", "shank", "foot"}
        bones[bone] = (head, tail, None if parent is None else parent + (dot + side if sided else ""))
    weights = {
        bone: (np.flatnonzero(column > 0.0), column[column > 0.0])
        for bone, column in zip(figure_body.BONES, body.weights.T, strict=True)
    }
    order = sorted(bones, key=lambda bone: _depth(bones, bone))
    turns = (("upper_arm.L", (0.0, 1.0, 0.0), -50.0), ("forearm.L", (0.0, 0.0, 1.0), -115.0))
    bones = {bone: bones[bone] for bone in order}
    return Figure(body.vertices, body.quads, bones, weights, (at["shoulder.L"], at["elbow.L"]), turns)


def _depth(bones, bone):
    parent = bones[bone][2]
    return 0 if parent is None else 1 + _depth(bones, parent)
