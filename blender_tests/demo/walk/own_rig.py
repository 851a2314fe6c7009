# SPDX-License-Identifier: GPL-3.0-or-later
"""The generated walk on MakeHuman's body, which its own rig carries: what skinning shows is the truth.

The markers are vertices of the skinned body. As examples serve poses of the rig that have nothing to do with the walk.
"""

import dataclasses
from types import SimpleNamespace

import numpy as np
from support import mesh_files, walking_figure

from ..example import limbs
from ..rig import figures
from . import subjects

FRAMES, SEED = 170, 7

#: How a bone of MakeHuman's begins: the bone of the walking figure that it goes with. All others go with the head.
PARTS = {
    "upperarm": "upper_arm", "lowerarm": "forearm", "wrist": "forearm", "finger": "forearm", "metacarpal": "forearm",
    "upperleg": "thigh", "lowerleg": "shank", "foot": "foot", "toe": "foot",
    "root": "pelvis", "pelvis": "pelvis", "spine05": "pelvis", "spine04": "pelvis",
    "spine": "chest", "breast": "chest", "clavicle": "chest", "shoulder": "chest",
}  # fmt: skip
TRUNK = ("pelvis", "chest", "head")

#: Bone of the walking figure: where its own ends are among MakeHuman's, and where it points in the T-pose on the left.
LIMBS = {
    "upper_arm": ("upperarm01", "lowerarm01", (1.0, 0.0, 0.0)),
    "forearm": ("lowerarm01", "wrist", (1.0, 0.0, 0.0)),
    "thigh": ("upperleg01", "lowerleg01", (0.0, 0.0, -1.0)),
    "shank": ("lowerleg01", "foot", (0.0, 0.0, -1.0)),
}


def subject(folder, like):
    """A Subject that is posed like nothing ('NOTHING') or like its rig ('RIG')."""
    figure = _on_the_ground(figures.makehuman())
    heads = {bone: np.array(ends[0]) for bone, ends in figure.bones.items()}
    to_t_pose = _to_t_pose(heads)
    truth = _skinned(figure, _bones_over_time(figure, heads, to_t_pose))
    vertices = _marked(figure, heads, to_t_pose)
    clean = truth[:, vertices]
    rng = np.random.default_rng(SEED)
    noisy = clean + subjects.NOISE * rng.standard_normal(clean.shape)
    stem = f"walk_own_rig_{like.lower()}"
    take = _take(walking_figure.drop_samples(noisy, subjects.GAPS, rng))
    standing = _take(np.repeat(figure.vertices[None, vertices], 5, axis=0))
    return subjects.Subject(
        f"Walk on MakeHuman's body, posed like {'its rig' if like == 'RIG' else 'nothing'}",
        stem,
        figure.vertices,
        figure.polygons,
        subjects.write(folder / f"{stem}.c3d", take),
        subjects.write(folder / f"{stem}_standing.c3d", standing),
        subjects.steps_of(FRAMES),
        truth=truth,
        markers=clean,
        rig=figure,
        like=like,
    )


MAKERS = {f"own rig, {like.lower()}": (lambda folder, like=like: subject(folder, like)) for like in ("NOTHING", "RIG")}


def missing(_title):
    """The first file that is needed and is not there, or None."""
    path = mesh_files.DATA / "makehuman" / "default.mhskel"
    return None if path.is_file() else path


def _on_the_ground(figure):
    down = np.array([0.0, 0.0, figure.vertices[:, 2].min()])
    bones = {bone: (head - down, tail - down, parent) for bone, (head, tail, parent) in figure.bones.items()}
    return dataclasses.replace(figure, vertices=figure.vertices - down, bones=bones)


def _take(positions):
    return SimpleNamespace(labels=walking_figure.LABELS, positions=positions, rate_hz=walking_figure.RATE_HZ)


def _part(bone):
    """The bone of the walking figure that carries one of MakeHuman's."""
    name, _, side = bone.partition(".")
    part = next((part for start, part in PARTS.items() if name.startswith(start)), "head")
    return part if part in TRUNK else f"{part}.{side}"


def _to_t_pose(heads):
    """{bone of the walking figure: (3, 3)}: from how MakeHuman's body stands to the T-pose, elbows as hinges."""
    found = {}
    for part, (bone, next_bone, direction) in LIMBS.items():
        for side, sign in (("L", 1.0), ("R", -1.0)):
            along = heads[f"{next_bone}.{side}"] - heads[f"{bone}.{side}"]
            goal = np.array(direction) * [sign, 1.0, 1.0]
            hinges = np.eye(3)[0], np.eye(3)[0]
            if direction[0]:
                shoulder, elbow, wrist = (heads[f"{name}.{side}"] for name in ("upperarm01", "lowerarm01", "wrist"))
                hinges = limbs.elbow_hinge(elbow - shoulder, wrist - elbow), limbs.elbow_hinge(goal, goal)
            found[f"{part}.{side}"] = _axes(goal, hinges[1]) @ _axes(along, hinges[0]).T
    return found


def _axes(along, hinge):
    """(3, 3): the columns point along a limb, along the hinge across it, and across both."""
    along = along / np.linalg.norm(along)
    hinge = hinge - (hinge @ along) * along
    hinge /= np.linalg.norm(hinge)
    return np.stack([along, hinge, np.cross(along, hinge)], axis=1)


def _bones_over_time(figure, heads, to_t_pose):
    """{bone: ((f, 3) where its head is, (f, 3, 3) how it is turned from how it stands)}."""
    joints, turns, _ = walking_figure.walking(np.arange(FRAMES) / walking_figure.RATE_HZ)
    leg = walking_figure.THIGH + walking_figure.SHANK
    share = (heads["upperleg01.L"] - heads["foot.L"])[2] / leg
    way = share * (joints["pelvis"] - walking_figure.upright(1, 1.0)[0]["pelvis"])
    found = {}
    for bone, (head, _tail, parent) in figure.bones.items():
        part = _part(bone)
        turn = turns[part] @ to_t_pose.get(part, np.eye(3))
        if parent is None:
            found[bone] = way + head, turn
        else:
            place, turn_of_parent = found[parent]
            found[bone] = place + turn_of_parent @ (heads[bone] - heads[parent]), turn
    return found


def _skinned(figure, bones):
    """(f, n, 3): linear blend skinning, as an Armature modifier has it."""
    total = np.zeros(len(figure.vertices))
    for indices, weights in figure.weights.values():
        total[indices] += weights
    result = np.zeros((FRAMES, *figure.vertices.shape))
    for bone, (indices, weights) in figure.weights.items():
        places, turns = bones[bone]
        local = figure.vertices[indices] - figure.bones[bone][0]
        moved = places[:, None] + np.einsum("fij,kj->fki", turns, local)
        result[:, indices] += (weights / total[indices])[None, :, None] * moved
    return result


def _marked(figure, heads, to_t_pose):
    """Vertices that the markers of the walking figure are nearest to, in its order."""
    size = np.ptp(figure.vertices[:, 2]) / walking_figure.HEIGHT
    pelvis = 0.5 * (heads["upperleg01.L"] + heads["upperleg01.R"]) + [0.0, 0.0, 0.05 * size]
    joints = {"pelvis": pelvis, "chest": pelvis + np.array([0.0, 0.0, 0.16 * size]), "head": heads["neck02"]}
    turns = dict.fromkeys(TRUNK, np.eye(3))
    for side in "LR":
        for joint, bone in (("shoulder", "upperarm01"), ("elbow", "lowerarm01"), ("hip", "upperleg01"),
                            ("knee", "lowerleg01"), ("ankle", "foot")):  # fmt: skip
            joints[f"{joint}.{side}"] = heads[f"{bone}.{side}"]
        turns[f"foot.{side}"] = np.eye(3)
    turns |= {part: turn.T for part, turn in to_t_pose.items()}
    thigh = np.linalg.norm(heads["upperleg01.L"] - heads["lowerleg01.L"])
    legs = thigh / (size * walking_figure.THIGH)
    places = walking_figure.markers_on(
        {name: place[None] / size for name, place in joints.items()},
        {name: turn[None] for name, turn in turns.items()},
        legs,
    )[0]
    away = np.linalg.norm(figure.vertices[None] - size * places[:, None], axis=2)
    return away.argmin(axis=1)
