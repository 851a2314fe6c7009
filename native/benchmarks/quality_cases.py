# SPDX-License-Identifier: MPL-2.0
"""The cases of bench_quality: captured and modelled poses, the two set-ups of Botsch and Sorkine, analytic checks."""

from dataclasses import dataclass

import numpy as np

from blender_tests.support import mesh_files
from native.benchmarks import generated_meshes, reporting, rigid, shape_metrics
from native.benchmarks.peers.job import KEEP, RESTART, Job
from native.benchmarks.table1_cases import Edges

POSE_SETS = {"horse_poses": 1, "horse_gallop": 3, "samba": 3, "face_poses": 1}  # every so many poses are taken
SYMMETRIC_VERTICES, SPIKE_FREQUENCY = 2000, 16
SYMMETRIC_DEG, SPIKE_PULL = 45.0, 0.2  # each end; over the diagonal


@dataclass
class PoseSet:
    """Poses of one mesh: numbers in the file (p,), truths (p, n, 3), and the job that asks for them."""

    name: str
    numbers: np.ndarray
    truths: np.ndarray
    job: Job


def pose_sets(names, anchor_count, thin_out=1):
    """The pose sets of these names with so many anchors; only every `thin_out`th of the poses that are used."""
    for name, stride in POSE_SETS.items():
        if name not in names:
            continue
        path = mesh_files.DATA / "poses" / f"{name}.npz"
        if not path.exists():
            reporting.missing(f"poses/{path.name}")
            continue
        data = np.load(path)
        rest, faces = data["rest"].astype(float), data["faces"].astype(np.int32)
        numbers = np.arange(len(data["poses"]))[:: stride * thin_out]
        truths = data["poses"][numbers].astype(float)
        anchors = shape_metrics.farthest_points(Edges(rest, faces), rest, anchor_count)
        yield PoseSet(name, numbers, truths, single_anchors(rest, faces, anchors, truths[:, anchors]))


def single_anchors(vertices, faces, anchors, targets):
    """A job where every anchor is a piece of its own and every pose is solved from the rest shape."""
    plan = np.full(len(targets), RESTART | KEEP, np.int32)
    return Job(vertices, faces, np.asarray(anchors), np.arange(len(anchors)), np.asarray(targets), plan)


def handles(name):
    """(job, kinds (n,)) of handles/`name`: 0 fixed, 1 free, 2 moved by the given matrix; None where it is missing."""
    folder = mesh_files.DATA / "handles"
    if not (folder / f"{name}.off").exists():
        reporting.missing(f"{folder.name}/{name}.off")
        return None
    vertices, faces = mesh_files.read_triangles(folder / f"{name}.off")
    kinds = np.loadtxt(folder / f"{name}.sel", comments="#").ravel().astype(int)
    matrix = np.loadtxt(folder / f"{name}.def", comments="#").reshape(4, 4)
    anchors = np.flatnonzero(kinds != 1)
    moving = kinds[anchors] == 2
    targets = vertices[anchors].copy()
    targets[moving] = targets[moving] @ matrix[:3, :3].T + matrix[:3, 3]
    pieces = np.where(moving, 0, -1)
    return Job(vertices, faces, anchors, pieces, targets[None], np.array([RESTART | KEEP])), kinds


def cross_sections(vertices, kinds, axis, count=20):
    """(count,) arrays of numbers of the free vertices, by height along an axis, all layers alike in thickness."""
    free = np.flatnonzero(kinds == 1)
    heights = vertices[free, axis]
    edges = np.linspace(heights.min(), heights.max(), count + 1)
    layer = np.clip(np.searchsorted(edges, heights, side="right") - 1, 0, count - 1)
    return [free[layer == k] for k in range(count) if (layer == k).sum() >= 3]


def long_axis(vertices):
    """The coordinate axis along which the shape is longest."""
    return int(np.ptp(vertices, axis=0).argmax())


def symmetric_bend():
    """The generated bar, both ends turned by SYMMETRIC_DEG towards each other: as alike as two hands."""
    vertices, faces = generated_meshes.bar(SYMMETRIC_VERTICES, bumpy=False)
    low, high = vertices[:, 2] < 0.5, vertices[:, 2] > generated_meshes.BAR_LENGTH - 0.5
    anchors = np.flatnonzero(low | high)
    targets = vertices[anchors].copy()
    for end, sign in ((low, 1.0), (high, -1.0)):
        chosen = end[anchors]
        centre = np.array([0, 0, 0.25 if sign > 0 else generated_meshes.BAR_LENGTH - 0.25])
        rotation = rigid.rotation_about([1, 0, 0], sign * SYMMETRIC_DEG)
        targets[chosen] = (targets[chosen] - centre) @ rotation.T + centre
    pieces = np.where(low[anchors], 0, 1)
    return Job(vertices, faces, anchors, pieces, targets[None], np.array([RESTART | KEEP]))


def pulled_anchor():
    """(job, the anchor): a sphere whose lower third is held, its top pulled up by one vertex."""
    vertices, faces = generated_meshes.sphere(SPIKE_FREQUENCY)
    top = int(vertices[:, 2].argmax())
    anchors = np.append(np.flatnonzero(vertices[:, 2] < -1 / 3), top)
    targets = vertices[anchors].copy()
    targets[-1, 2] += SPIKE_PULL * np.linalg.norm(np.ptp(vertices, axis=0))
    pieces = np.append(np.full(len(anchors) - 1, -1), 0)
    return Job(vertices, faces, anchors, pieces, targets[None], np.array([RESTART | KEEP])), top
