# SPDX-License-Identifier: MPL-2.0
"""The full solver (equation 15 to convergence): iterations, seconds by stage, energy at diagonal 1."""

import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

import meanvalue

from blender_tests.support import mesh_files
from native.benchmarks import bench_encode, reporting

COLUMNS = [
    "case", "vertices", "free", "anchors", "encode s", "analyse s", "solve s", "iterations",
    "to within 5%", "G start", "G end", "gradient end/start", "stop",
]  # fmt: skip


def farthest_points(vertices, count):
    """Numbers of `count` vertices far from each other, beginning at vertex 0."""
    chosen = [0]
    distance = np.linalg.norm(vertices - vertices[0], axis=1)
    while len(chosen) < count:
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, np.linalg.norm(vertices - vertices[chosen[-1]], axis=1))
    return np.array(chosen)


def measure(name, vertices, triangles, anchors, targets, roi=None):
    """One row of the table."""
    deformer = meanvalue.Deformer(vertices, triangles, anchors, roi=roi, method="full")
    solution = deformer.solve(targets)
    squared_diagonal = np.sum(np.ptp(vertices, axis=0) ** 2)
    energies = np.array(solution.energies)
    near = int(np.argmax(energies <= 1.05 * energies[-1]))
    report = deformer.report
    return [
        name, report.vertex_count, report.free_count, report.anchor_count, report.timings["encode"],
        report.timings["analyse"], solution.timings["total"], solution.iterations, near,
        energies[0] / squared_diagonal, energies[-1] / squared_diagonal,
        solution.gradient / max(solution.initial_gradient, 1e-300), solution.stop_reason,
    ]  # fmt: skip


def pulled_torus():
    """Generated: a bump of a torus pulled out by one anchor in a region of influence."""
    vertices, triangles = bench_encode.generated_torus(160, 78)
    tip = int(vertices[:, 0].argmax())
    roi = np.linalg.norm(vertices - vertices[tip], axis=1) < 1.5
    return measure("torus, 1 anchor", vertices, triangles, [tip], vertices[[tip]] + [1.0, 0, 0.5], roi)


def twisted_bar():
    """handles/bar: both ends held, one turned by 135 degrees."""
    vertices, triangles = mesh_files.read_triangles(mesh_files.DATA / "handles" / "bar.off")
    kinds = read_numbers("bar.sel").ravel().astype(int)
    matrix = read_numbers("bar.def").reshape(4, 4)
    targets = vertices.copy()
    targets[kinds == 2] = vertices[kinds == 2] @ matrix[:3, :3].T + matrix[:3, 3]
    anchors = np.flatnonzero(kinds != 1)
    return measure("bar twisted 135", vertices, triangles, anchors, targets[anchors])


def read_numbers(name):
    """The numbers of a .sel or .def file, without its comment lines."""
    return np.loadtxt(mesh_files.DATA / "handles" / name, comments="#")


def horse_pose(number):
    """A real pose from 40 scattered single-vertex anchors: the hardest kind of start."""
    poses = np.load(mesh_files.DATA / "poses" / "horse_poses.npz")
    vertices = poses["rest"].astype(float)
    anchors = farthest_points(vertices, 40)
    targets = poses["poses"][number].astype(float)[anchors]
    return measure(f"horse pose {number}", vertices, poses["faces"].astype(np.int32), anchors, targets)


def feline_wing(free_count):
    """The paper's feline: the vertex farthest up in a wing moved, the nearest `free_count` vertices free."""
    vertices, triangles = mesh_files.read_triangles(mesh_files.DATA / "models" / "feline.off")
    tip = int(vertices[:, 1].argmax())
    distance = np.linalg.norm(vertices - vertices[tip], axis=1)
    roi = distance <= np.partition(distance, free_count)[free_count]
    target = vertices[[tip]] + 0.1 * np.linalg.norm(np.ptp(vertices, axis=0)) * np.array([0.5, 0.5, 0.5])
    return measure(f"feline, {free_count} free", vertices, triangles, [tip], target, roi)


if __name__ == "__main__":
    json_path = reporting.json_argument(__doc__)
    rows = [pulled_torus()]
    if mesh_files.model_paths():
        rows += [twisted_bar(), *map(horse_pose, (0, 4, 8)), feline_wing(5000), feline_wing(20000)]
    else:
        reporting.missing("the real models")
    reporting.report("full solver", COLUMNS, rows, json_path)
