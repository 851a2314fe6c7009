# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies with bones and skin weights: the project's own figure, and MakeHuman's where the shared data is there."""

import json
from dataclasses import dataclass

import numpy as np
from support import figure_body, mesh_files, walking_figure


@dataclass(frozen=True, eq=False)
class Figure:
    """vertices (n, 3), Z up, and polygons

    bones    {name: (head, tail, name of the parent or None)}, parents first
    weights  {bone: (indices, weights)}
    arm      (shoulder, elbow): joints
    turns    ((bone, axis, degrees), ...) in the world, in their order
    """

    title: str
    stem: str
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
    ends = {
        "pelvis": "chest",
        "chest": "neck",
        "upper_arm": "elbow",
        "forearm": "wrist",
        "thigh": "knee",
        "shank": "ankle",
    }
    heads = {"upper_arm": "shoulder", "forearm": "elbow", "thigh": "hip", "shank": "knee", "foot": "ankle"}
    parents = {"chest": "pelvis", "head": "chest", "upper_arm": "chest", "forearm": "upper_arm", "thigh": "pelvis"}
    parents |= {"shank": "thigh", "foot": "shank"}
    bones = {}
    for bone in figure_body.BONES:
        name, dot, side = bone.partition(".")
        head = at[heads.get(name, name) + dot + side]
        end = ends.get(name)
        tail = at.get(f"{end}{dot}{side}", at.get(end)) if end else head + np.array((0.0, -0.1, 0.0))
        parent = parents.get(name)
        sided = parent in {"upper_arm", "thigh", "shank"}
        bones[bone] = (head, tail, None if parent is None else parent + (dot + side if sided else ""))
    weights = {
        bone: (np.flatnonzero(column > 0.0), column[column > 0.0])
        for bone, column in zip(figure_body.BONES, body.weights.T, strict=True)
    }
    order = sorted(bones, key=lambda bone: _depth(bones, bone))
    turns = (("upper_arm.L", (0.0, 1.0, 0.0), -50.0), ("forearm.L", (0.0, 0.0, 1.0), -115.0))
    return Figure(
        "the walking figure",
        "walker",
        body.vertices,
        body.quads,
        {bone: bones[bone] for bone in order},
        weights,
        (at["shoulder.L"], at["elbow.L"]),
        turns,
    )


def makehuman():
    """MakeHuman's base body with its own bones and weights, which are never copied."""
    folder = mesh_files.DATA / "makehuman"
    vertices, polygons = mesh_files.read_obj(folder / "base.obj")
    points = 0.1 * np.stack([vertices[:, 0], -vertices[:, 2], vertices[:, 1]], axis=1)
    count = 13380
    skeleton = json.loads((folder / "default.mhskel").read_text())
    joints = {name: points[members].mean(axis=0) for name, members in skeleton["joints"].items()}
    named = skeleton["bones"]
    order = sorted(named, key=lambda bone: _depth({name: (0, 0, each["parent"]) for name, each in named.items()}, bone))
    bones = {bone: (joints[named[bone]["head"]], joints[named[bone]["tail"]], named[bone]["parent"]) for bone in order}
    weights = {}
    for bone, pairs in json.loads((folder / "default_weights.mhw").read_text())["weights"].items():
        of_body = np.array([pair for pair in pairs if pair[0] < count])
        if len(of_body):
            weights[bone] = (of_body[:, 0].astype(int), of_body[:, 1])
    return Figure(
        "MakeHuman's body",
        "makehuman",
        points[:count],
        [polygon for polygon in polygons if max(polygon) < count],
        bones,
        weights,
        (bones["upperarm01.L"][0], bones["lowerarm01.L"][0]),
        (("upperarm01.L", (0.0, 1.0, 0.0), -75.0), ("lowerarm01.L", (0.0, 0.6, 1.0), -115.0)),
    )


def _depth(bones, bone):
    parent = bones[bone][2]
    return 0 if parent is None else 1 + _depth(bones, parent)
