# SPDX-License-Identifier: MPL-2.0
"""Encoding and prediction of a whole mesh on one thread: seconds, and how exactly the rest shape comes back."""

import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

import meanvalue

from blender_tests.support import mesh_files
from native.benchmarks import reporting

COLUMNS = ["model", "vertices", "encode s", "predict s", "energy s", "largest error / diagonal", "guarded"]


def generated_torus(around, across):
    """A torus of around * across vertices with ripples: (n, 3) vertices, (2n, 3) triangles."""
    u, v = np.meshgrid(
        2 * np.pi * np.arange(around) / around, 2 * np.pi * np.arange(across) / across, indexing="ij"
    )
    tube = 1 + 0.05 * np.sin(20 * u) * np.sin(9 * v)
    radius = 3 + tube * np.cos(v)
    vertices = np.stack([radius * np.cos(u), radius * np.sin(u), tube * np.sin(v)], axis=-1).reshape(-1, 3)
    number = np.arange(around * across).reshape(around, across)
    corners = [number, np.roll(number, -1, 0), np.roll(np.roll(number, -1, 0), -1, 1), np.roll(number, -1, 1)]
    first = np.stack([corners[0], corners[1], corners[2]], axis=-1).reshape(-1, 3)
    second = np.stack([corners[0], corners[2], corners[3]], axis=-1).reshape(-1, 3)
    return vertices, np.concatenate([first, second]).astype(np.int32)


def meshes():
    """(name, vertices, triangles) of every mesh to measure."""
    yield "torus (generated)", *generated_torus(320, 156)
    paths = mesh_files.model_paths()
    if not paths:
        reporting.missing("the real models")
    for path in paths:
        yield path.name, *mesh_files.read_triangles(path)


def measure(name, vertices, triangles):
    """One row of the table."""
    encode_seconds, encoding = reporting.median_seconds(
        lambda: meanvalue.encode(vertices, triangles, threads=1), repeats=5
    )
    predict_seconds, predicted = reporting.median_seconds(
        lambda: encoding.predict(vertices, threads=1), repeats=5
    )
    energy_seconds, _ = reporting.median_seconds(lambda: encoding.energy(vertices, threads=1), repeats=5)
    diagonal = np.linalg.norm(np.ptp(vertices, axis=0))
    error = np.linalg.norm(predicted - vertices, axis=1).max() / diagonal
    return [name, len(vertices), encode_seconds, predict_seconds, energy_seconds, float(error), len(encoding.guarded)]


if __name__ == "__main__":
    json_path = reporting.json_argument(__doc__)
    rows = [measure(*mesh) for mesh in meshes()]
    reporting.report("encode and predict, 1 thread", COLUMNS, rows, json_path)
