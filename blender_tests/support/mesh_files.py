# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads mesh files as triangles, for tests and benchmarks that run without Blender."""

import os
import pathlib

import numpy as np

from blender_tests.demo.off_file import read_off

# Real meshes are kept beside the checkout, never in it: they may not be shipped.
DATA = pathlib.Path(os.environ.get("MEANVALUE_DATA", pathlib.Path(__file__).resolve().parents[3] / "shared" / "data"))


def model_paths(folder="models"):
    """The mesh files in a folder of the shared data, sorted; empty where it is missing."""
    return sorted(path for path in (DATA / folder).glob("*") if path.suffix in (".off", ".obj"))


def read_triangles(path):
    """Vertices (n, 3) float64 and triangles (m, 3) int32 of an OFF or OBJ file; polygons are split into fans."""
    vertices, polygons = read_off(path) if path.suffix == ".off" else read_obj(path)
    triangles = [(polygon[0], polygon[k], polygon[k + 1]) for polygon in polygons for k in range(1, len(polygon) - 1)]
    return vertices, np.array(triangles, np.int32).reshape(-1, 3)


def read_obj(path):
    """Vertices (n, 3) and polygons (lists of vertex numbers from 0) of an OBJ file."""
    vertices = []
    polygons = []
    with path.open(encoding="utf-8", errors="replace") as file:
        for line in file:
            words = line.split()
            if not words:
                continue
            if words[0] == "v":
                vertices.append([float(word) for word in words[1:4]])
            elif words[0] == "f":
                numbers = [int(word.split("/")[0]) for word in words[1:]]
                polygons.append([number - 1 if number > 0 else len(vertices) + number for number in numbers])
    return np.array(vertices, np.float64).reshape(-1, 3), polygons


def path_of(name):
    """A file of the shared data; skips the test where it is missing."""
    path = DATA / name
    if not path.is_file():
        import pytest

        pytest.skip(f"there is no {path}")
    return path


def content_of(name):
    """The bytes of a file of the shared data; skips the test where it is missing."""
    return path_of(name).read_bytes()


def real_body(name):
    """(vertices, triangles) of a person of the shared data with Z up, looking along -Y; MakeHuman's without helpers."""
    vertices, triangles = read_triangles(path_of(name))
    if name.startswith("makehuman"):
        triangles = triangles[(triangles < 13380).all(axis=1)]
    return vertices[:, [0, 2, 1]] * [1.0, -1.0, 1.0], triangles
