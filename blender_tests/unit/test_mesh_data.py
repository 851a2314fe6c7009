# SPDX-License-Identifier: GPL-3.0-or-later
"""What is read of a mesh: its arrays, vertex groups, shape keys and those that may be driven, bit by bit."""

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


# -- shape keys --------------------------------------------------------------------------------------------------------


@pytest.fixture
def shape_keys(part):
    return part("scene.shape_keys")


def test_the_basis_may_have_any_name_and_place(shape_keys):
    obj = meshes.grid()
    obj.shape_key_add(name="Rest of Them")
    obj.shape_key_add(name="Basis")
    obj.active_shape_key_index = 1
    obj.meanvalue.result_key = "Rest of Them"
    assert "is the rest shape" in shape_keys.result_problem(obj)
    obj.meanvalue.result_key = "Basis"
    assert shape_keys.result_problem(obj) is None


def test_a_pinned_pose_is_pointed_out(shape_keys):
    obj = meshes.grid()
    steps.add_pose_key(obj)
    obj.show_only_shape_key = True
    notes = shape_keys.write_result(obj, np.zeros((25, 3), np.float32))
    assert "is pinned" in notes[-1]
    assert obj.show_only_shape_key


# -- shape keys that may be driven -------------------------------------------------------------------------------------


@pytest.fixture
def key_shapes(part):
    return part("sliders.bridge.key_shapes")


def add_key(obj, name, seed=0, relative="Basis"):
    rng = np.random.default_rng(seed)
    return steps.add_key(obj, name, rng.normal(size=3 * len(obj.data.vertices)), relative)


@pytest.fixture
def obj():
    obj = meshes.grid()
    obj.shape_key_add(name="Basis")
    return obj


def test_shapes_are_those_that_blender_shows(obj, key_shapes):
    add_key(obj, "Plain", 1)
    chained = add_key(obj, "Chained", 2, relative="Plain")
    steps.add_weights(obj, "Part", np.linspace(0.0, 1.0, 25))
    chained.vertex_group = "Part"
    chained.slider_min, chained.slider_max = -1.0, 2.0
    found = key_shapes.gather(obj)
    assert found.names == ("Plain", "Chained")
    assert found.bounds.tolist() == [[0.0, -1.0], [1.0, 2.0]]
    key_shapes.set_values(obj, found.names, [0.25, 1.5])
    np.testing.assert_allclose(meshes.seen(obj), found.mixed(key_shapes.values(obj, found.names)), atol=1e-5)


def test_what_is_not_ours_to_move_is_left_alone_and_said_so(obj, key_shapes):
    add_key(obj, "Free", 1)
    add_key(obj, "Muted", 2).mute = True
    add_key(obj, "Driven", 3).driver_add("value")
    copy = add_key(obj, "Copy")
    copy.data.foreach_set("co", steps.key_positions(obj, "Basis").ravel())
    obj.meanvalue.result_key = add_key(obj, "Result", 5).name
    locked = hasattr(copy, "lock_shape")
    if locked:
        add_key(obj, "Locked", 6).lock_shape = True
    found = key_shapes.gather(obj)
    assert found.names == ("Free",)
    assert dict(found.left_alone) == {
        "Muted": "muted",
        "Driven": "moved by a driver",
        "Copy": "without effect",
        **({"Locked": "locked"} if locked else {}),
    }


def test_nothing_to_drive_is_told(obj, key_shapes, part):
    error = part("errors").SceneError
    with pytest.raises(error, match="has no shape keys to drive"):
        key_shapes.gather(obj)
    add_key(obj, "Muted", 1).mute = True
    assert "can be driven: 'Muted' (muted) is left alone" in key_shapes.problem(obj)
    copy = add_key(obj, "Copy")
    copy.data.foreach_set("co", steps.key_positions(obj, "Basis").ravel())
    assert key_shapes.problem(obj) is None
    with pytest.raises(error, match="without effect"):
        key_shapes.gather(obj)
    obj.data.shape_keys.use_relative = False
    with pytest.raises(error, match="absolute"):
        key_shapes.gather(obj)
