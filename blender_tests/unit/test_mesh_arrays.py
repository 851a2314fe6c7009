# SPDX-License-Identifier: GPL-3.0-or-later
"""scene/mesh_arrays.py and the parts of compat.py that it uses."""

import bpy
import numpy as np
import pytest
from support import meshes, steps


@pytest.fixture
def arrays(part):
    return part("scene.mesh_arrays")


@pytest.fixture
def gather(part):
    return part("posing.bridge.scene_input").gather


def test_faces_keep_their_corners_and_sizes(arrays):
    mesh = meshes.tube().data
    corners, starts = arrays.faces(mesh)
    assert corners.dtype == starts.dtype == np.int32
    ends = [*starts[1:], len(corners)]
    faces = [tuple(corners[start:end]) for start, end in zip(starts, ends, strict=True)]
    assert faces == [tuple(polygon.vertices) for polygon in mesh.polygons]


def test_nothing_to_read(arrays):
    mesh = bpy.data.meshes.new("Nothing")
    assert arrays.vertex_positions(mesh).shape == (0, 3)
    assert [len(array) for array in arrays.faces(mesh)] == [0, 0]


def blender_triangles(mesh):
    mesh.calc_loop_triangles()
    return [tuple(triangle.vertices) for triangle in mesh.loop_triangles]


@pytest.mark.parametrize("corners", [4, 5, 9, 24])
def test_the_module_splits_polygons_as_blender_does(arrays, native, corners):
    random = np.random.default_rng(corners)
    angles_rad = np.sort(random.uniform(0.0, 2.0 * np.pi, (20, corners)), axis=1)
    flat = np.stack([np.cos(angles_rad), np.sin(angles_rad), 0.1 * angles_rad], axis=2)
    places = flat * random.uniform(0.2, 1.0, (20, corners, 1)) @ np.linalg.qr(random.normal(size=(3, 3)))[0]
    faces = np.arange(20 * corners).reshape(20, corners)
    mesh = bpy.data.meshes.new("Polygons")
    mesh.from_pydata(np.float32(places).reshape(-1, 3).tolist(), [], faces.tolist())
    triangles, polygons = native.triangulate(arrays.vertex_positions(mesh), faces)
    assert {frozenset(triangle) for triangle in triangles.tolist()} == set(map(frozenset, blender_triangles(mesh)))
    assert np.array_equal(polygons, np.repeat(np.arange(20), corners - 2))


def anchored(obj):
    steps.list_anchors(obj, A=[0, 4, 20])
    return obj


def fold(obj, sign):
    """Bends every quad of a grid so that Blender splits it along one diagonal or the other."""
    for vertex in obj.data.vertices:
        row, column = divmod(vertex.index, 5)
        vertex.co.z = sign * 0.8 * (column - row) ** 2
        vertex.co.x += 0.5 * sign * row


def test_triangles_are_those_of_the_rest_shape(arrays, gather):
    """The mesh's own vertices are in another shape than the Basis."""
    obj = meshes.grid()
    quads = {}
    for sign in (1, -1):
        shaped = meshes.grid(name=f"Shape {sign}")
        fold(shaped, sign)
        shaped.data.update()
        quads[sign] = blender_triangles(shaped.data)
    assert quads[1] != quads[-1], "the two shapes should be split differently"

    fold(obj, 1)
    obj.data.update()
    obj.shape_key_add(name="Basis")
    fold_back = meshes.grid(name="Other")
    fold(fold_back, -1)
    obj.data.vertices.foreach_set("co", arrays.vertex_positions(fold_back.data).ravel())
    obj.data.update()
    assert blender_triangles(obj.data) == quads[-1]
    meshes.activate(obj)
    anchored(obj)
    meshes_before = bpy.data.meshes.keys()
    assert [tuple(t) for t in arrays.triangles(obj.data, gather(obj).rest).tolist()] == quads[1]
    assert bpy.data.meshes.keys() == meshes_before, "the temporary mesh stays behind"
