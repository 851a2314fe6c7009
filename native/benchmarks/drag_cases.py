# SPDX-License-Identifier: MPL-2.0
"""The cases of bench_drag: whole meshes held by few handles, one of which is carried away and turned frame by frame.

Every job of a case solves the first frame's targets from rest, the last frame's from rest, then rest's own, and from
there the frames, each from the answer before.
"""

from dataclasses import dataclass, replace

import numpy as np

from blender_tests.support import mesh_files
from native.benchmarks import generated_creature, generated_meshes, reporting, shape_metrics
from native.benchmarks.peers.job import RESTART, Job

SINGLE, PATCHES, ENDS = "single", "patches", "ends"
POINTS = {SINGLE: 9, PATCHES: 6}
PATCH_RADIUS, CARRY = 0.025, 0.15  # over the diagonal
TURN_DEG = 40.0
FIRST, LAST, AT_REST, FRAMES_FROM = 0, 1, 2, 3  # steps of a job
#: Those of the page: others say the same.
USUAL = (
    "armadillo_14k", "beast_quads", "dolphin_quads_open", "feline", "horse", "human_man", "octopus", "spot",
    "creature_20k", "creature_50k",
)  # fmt: skip
CREATURES = {"creature_7k": 7_000, "creature_20k": 20_000, "creature_50k": 50_000}
TUBES = ("tube", "body", "bar")
TUBE_AROUND, TUBE_ALONG, TUBE_LENGTH, TUBE_HELD, TUBE_STEP = 160, 310, 20.0, 0.5, 0.02  # radius 1; radians a frame
BALL_SIZE = 50_000  # of body and bar


@dataclass
class Model:
    """A name, (n, 3) vertices and (m, 3) triangles, and the set-ups it is dragged in."""

    name: str
    vertices: np.ndarray
    faces: np.ndarray
    setups: tuple = (SINGLE, PATCHES)


def models(names=None, messy=False, tubes=False):
    """The models of these names, or the usual ones, and with `messy` and `tubes` those too. Tells what isn't there."""
    paths = {path.stem: path for folder in ("models", "messy") for path in mesh_files.model_paths(folder)}
    wanted = [*(names or USUAL)]
    if messy:
        wanted += [path.stem for path in mesh_files.model_paths("messy")]
    if tubes:
        wanted += TUBES
    for name in dict.fromkeys(wanted):
        if name in paths:
            yield Model(name, *mesh_files.read_triangles(paths[name]))
        elif name in CREATURES:
            yield Model(name, *generated_creature.creature(CREATURES[name]))
        elif name in TUBES:
            yield Model(name, *tube_like(name), (ENDS,))
        else:
            reporting.missing(f"the model {name}")


def tube_like(name):
    """(vertices, triangles) of one of TUBES."""
    return open_tube() if name == "tube" else getattr(generated_meshes, name)(BALL_SIZE)


def open_tube():
    """A tube of radius 1 along z from 0 to TUBE_LENGTH, open at both ends."""
    angle, height = np.meshgrid(
        2 * np.pi * np.arange(TUBE_AROUND) / TUBE_AROUND, np.linspace(0, TUBE_LENGTH, TUBE_ALONG)
    )
    number = np.arange(angle.size).reshape(angle.shape)
    low, high = number[:-1], number[1:]
    next_low, next_high = np.roll(low, -1, axis=1), np.roll(high, -1, axis=1)
    faces = np.concatenate([np.stack(f, axis=-1).reshape(-1, 3)
                            for f in ((low, next_low, next_high), (low, next_high, high))])  # fmt: skip
    return np.stack([np.cos(angle), np.sin(angle), height], axis=-1).reshape(-1, 3), faces.astype(np.int32)


def job(model, setup, frame_count):
    """The drag of a model in a set-up, in so many frames."""
    if setup == ENDS:
        return ends_job(model, frame_count)
    anchors, pieces, moving = handles(model.vertices, model.faces, setup)
    rest = model.vertices[anchors]
    centroid = model.vertices.mean(axis=0)
    centre = rest[moving].mean(axis=0)
    diagonal = np.linalg.norm(np.ptp(model.vertices, axis=0))
    sideways, axis = sideways_and_axis(centre - centroid)
    motions = [generated_meshes.turn(centre, axis, TURN_DEG * t, CARRY * diagonal * t * sideways)
               for t in np.arange(1, frame_count + 1) / frame_count]  # fmt: skip
    return as_job(model, anchors, pieces, moving, motions)


def ends_job(model, frame_count):
    """Both ends held: the tube bent by TUBE_STEP a frame; body and bar on the path of bench_speed, at its pace."""
    if model.name != "tube":
        made = generated_meshes.speed_job(model.name, BALL_SIZE)
        steps = steps_of(made.vertices[made.anchors], made.targets[1 : frame_count + 1])
        return Job(made.vertices, made.faces, made.anchors, made.pieces + 1, *steps)
    height = model.vertices[:, 2]
    anchors = np.flatnonzero((height < TUBE_HELD) | (height > TUBE_LENGTH - TUBE_HELD))
    moving = height[anchors] > TUBE_LENGTH / 2
    angles = np.degrees(TUBE_STEP * np.arange(1, frame_count + 1))
    motions = [generated_meshes.bend(angle, np.zeros(3), TUBE_LENGTH) for angle in angles]
    return as_job(model, anchors, moving.astype(int), moving, motions)


def as_job(model, anchors, pieces, moving, motions):
    """The job whose moving anchors follow the motions, (rotation, shift) for each frame."""
    rest = model.vertices[anchors]
    targets = np.repeat(rest[None], len(motions), axis=0)
    for frame, (rotation, shift) in enumerate(motions):
        targets[frame, moving] = rest[moving] @ rotation.T + shift
    return Job(model.vertices, model.faces, anchors, pieces, *steps_of(rest, targets))


def steps_of(rest, frames):
    """(targets, plan) of a job's steps, see the module, for the frames' targets (f, k, 3)."""
    plan = np.zeros(len(frames) + FRAMES_FROM, np.int32)
    plan[[FIRST, LAST, AT_REST]] = RESTART
    return np.concatenate([frames[:1], frames[-1:], rest[None], frames]), plan


def handles(vertices, faces, setup):
    """Anchors (k,), ascending, their pieces (k,) and which of them (k,) bool are carried: the piece farthest out."""
    seeds = farthest_points(vertices, np.unique(faces), POINTS[setup])
    groups = [np.array([seed]) for seed in seeds] if setup == SINGLE else patches(vertices, faces, seeds)
    centroid = vertices.mean(axis=0)
    far = [np.linalg.norm(vertices[group].mean(axis=0) - centroid) for group in groups]
    piece = np.full(len(vertices), -1)
    for number, group in enumerate(groups):
        piece[group] = number
    anchors = np.flatnonzero(piece >= 0)
    return anchors, piece[anchors], piece[anchors] == int(np.argmax(far))


def farthest_points(vertices, candidates, count):
    """Numbers of `count` of the candidates: the farthest from the centroid, then each as far as can be from those."""
    points = vertices[candidates]
    chosen = [int(np.linalg.norm(points - vertices.mean(axis=0), axis=1).argmax())]
    distance = np.linalg.norm(points - points[chosen[0]], axis=1)
    while len(chosen) < count:
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return candidates[chosen]


def patches(vertices, faces, seeds):
    """Of each seed the vertices within PATCH_RADIUS of it that edges between such vertices join to it."""
    radius = PATCH_RADIUS * np.linalg.norm(np.ptp(vertices, axis=0))
    edges, found = shape_metrics.unique_edges(faces), []
    for seed in seeds:
        near = np.linalg.norm(vertices - vertices[seed], axis=1) <= radius
        parts = part_numbers(len(vertices), edges[near[edges].all(axis=1)])
        found.append(np.flatnonzero(parts == parts[seed]))
    return found


def part_numbers(vertex_count, edges):
    """(n,) the lowest vertex that edges (e, 2) join each vertex to."""
    lowest = np.arange(vertex_count)
    while True:
        before = lowest.copy()
        ends = np.minimum(lowest[edges[:, 0]], lowest[edges[:, 1]])
        for side in (0, 1):
            np.minimum.at(lowest, edges[:, side], ends)
            np.minimum.at(lowest, before[edges[:, side]], ends)
        lowest = lowest[lowest]
        if np.array_equal(lowest, before):
            return lowest


def for_peer(given):
    """(the job, vertices left out, triangles left out) without what a peer refuses and we don't.

    That is the triangles at edges that another runs along in the same direction, and parts without anchors.
    """
    pairs = np.concatenate([given.faces[:, [0, 1]], given.faces[:, [1, 2]], given.faces[:, [2, 0]]])
    _, which, uses = np.unique(pairs, axis=0, return_inverse=True, return_counts=True)
    manifold = (uses[which.reshape(3, -1)] == 1).all(axis=0)
    faces = given.faces[manifold]
    parts = part_numbers(len(given.vertices), shape_metrics.unique_edges(faces))
    kept = np.isin(parts, parts[given.anchors])
    number = np.cumsum(kept) - 1
    faces = number[faces[kept[faces[:, 0]]]].astype(np.int32)
    left = replace(given, vertices=given.vertices[kept], faces=faces, anchors=number[given.anchors])
    return left, int((~kept).sum()), int((~manifold).sum())


def sideways_and_axis(outward):
    """Two unit vectors: perpendicular to `outward`, near the axis it has least of; and the axis of the turn there."""
    outward = outward / np.linalg.norm(outward)
    least = np.eye(3)[np.abs(outward).argmin()]
    sideways = least - (least @ outward) * outward
    sideways /= np.linalg.norm(sideways)
    return sideways, np.cross(outward, sideways)
