# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrap by its operators: pairs, the shape key, refusals."""

import bpy
import numpy as np
import pytest
from mathutils import Vector
from support import meshes, steps
from support.snapshot import assert_same, snapshot

PAIRS = {0: (0, 0, 1), 1: (1, 0, 0), 2: (0, 1, 0), 3: (-1, 0, 0), 4: (0, 0, -1)}


def ball(name, rings, around, stretch=(1.0, 1.0, 1.0)):
    """A ball of quads and fans, its five landmarks first: +Z, +X, +Y, -X, -Z. rings even, around a multiple of 4."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=around, ring_count=rings)
    obj = bpy.context.object
    points = np.array([vertex.co for vertex in obj.data.vertices])
    faces = [tuple(polygon.vertices) for polygon in obj.data.polygons]
    first = [int(np.linalg.norm(points - place, axis=1).argmin()) for place in PAIRS.values()]
    order = first + [k for k in range(len(points)) if k not in first]
    new = {old: k for k, old in enumerate(order)}
    bpy.data.objects.remove(obj)
    bpy.context.view_layer.update()
    return meshes.make_object(points[order] * stretch, [tuple(new[k] for k in face) for face in faces], name)


@pytest.fixture
def two():
    """(mesh, other): the other is an egg of another size, elsewhere, turned and scaled as an object."""
    other = ball("Egg", 14, 20, (1.0, 1.2, 1.6))
    other.location, other.rotation_euler, other.scale = (5.0, -2.0, 1.0), (0.4, 0.2, 1.9), (0.5, 0.5, 0.5)
    obj = ball("Ball", 20, 28)
    obj.location, obj.rotation_euler = (-1.0, 0.0, 0.3), (0.0, 0.0, -0.5)
    bpy.context.view_layer.update()
    return obj, other


def pick(obj, other, vertices=tuple(PAIRS), partners=()):
    places = np.array([vertex.co for vertex in other.data.vertices])
    meshes.activate(obj)
    obj.meanvalue.wrap.target = other
    for vertex in vertices:
        place = places[dict(partners).get(vertex, vertex)]
        assert bpy.ops.meanvalue.pick_wrap_pairs(vertex=vertex, place=tuple(place)) == {'FINISHED'}


def test_a_split_mesh_stays_closed():
    obj = ball("Ball", 12, 16)
    points = [vertex.co for vertex in obj.data.vertices]
    obj = meshes.make_object(*meshes.split(points, [face.vertices for face in obj.data.polygons]), "Split")
    obj.meanvalue.wrap.target = ball("Egg", 14, 20, (1.0, 1.1, 1.3))
    steps.run(obj, "wrap")
    assert meshes.gap(obj) == 0.0 and meshes.seen(obj)[:, 2].max() > 1.25


def in_the_world(obj, points):
    matrix = np.array(obj.matrix_world)
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def key_points(key):
    return np.array([point.co for point in key.data])


def test_the_other_shape_is_a_shape_key_in_the_mesh_s_own_space(two):
    obj, other = two
    basis = np.array([vertex.co for vertex in obj.data.vertices])
    pick(obj, other)
    assert bpy.ops.meanvalue.wrap() == {'FINISHED'}
    key = obj.data.shape_keys.key_blocks["Egg"]
    assert key.value == 1.0
    np.testing.assert_array_equal(key_points(obj.data.shape_keys.reference_key), basis)
    own = (in_the_world(obj, key_points(key)) - np.array(other.location)) @ np.array(other.matrix_world)[:3, :3] / 0.25
    radius = np.linalg.norm(own / (1.0, 1.2, 1.6), axis=1)
    assert abs(radius - 1.0).mean() < 0.012, "facets of the egg are no farther in"
    np.testing.assert_allclose(own[:5], np.array(list(PAIRS.values())) * (1.0, 1.2, 1.6), atol=0.02)
    assert len(obj.data.vertices) == len(basis)


@pytest.mark.slow
def test_again_it_writes_the_same_key_whatever_that_is_called_unless_it_was_edited(two):
    obj, other = two
    pick(obj, other)
    bpy.ops.meanvalue.wrap()
    key = obj.data.shape_keys.key_blocks["Egg"]
    first = key_points(key)
    key.name = "Mine"
    obj.shape_key_add(name="Egg").value = 0.0  # the artist's, which only bears the former name
    bpy.ops.meanvalue.wrap()
    keys = obj.data.shape_keys.key_blocks
    assert {key.name: key.value for key in keys[1:]} == {"Mine": 1.0, "Egg": 0.0}
    np.testing.assert_array_equal(key_points(keys["Mine"]), first)
    keys["Mine"].data[0].co.x += 1.0
    edited = key_points(keys["Mine"])
    bpy.ops.meanvalue.wrap()
    keys = obj.data.shape_keys.key_blocks
    assert {key.name: key.value for key in keys[1:]} == {"Mine": 0.0, "Egg": 0.0, "Egg.001": 1.0}
    np.testing.assert_array_equal(key_points(keys["Mine"]), edited)
    np.testing.assert_array_equal(key_points(keys["Egg.001"]), first)


@pytest.mark.slow
def test_a_mirrored_target_and_its_modifiers_count(two):
    obj, other = two
    other.scale = (-0.5, 0.5, 0.5)
    bpy.context.view_layer.update()
    other.modifiers.new("Finer", 'SUBSURF').levels = 1
    pick(obj, other, partners={1: 3, 3: 1})
    assert bpy.ops.meanvalue.wrap() == {'FINISHED'}
    evaluated = other.evaluated_get(bpy.context.evaluated_depsgraph_get())
    for point in in_the_world(obj, key_points(obj.data.shape_keys.key_blocks["Egg"]))[5::37]:
        found, place, *_ = evaluated.closest_point_on_mesh(other.matrix_world.inverted() @ Vector(point))
        assert found
        assert (other.matrix_world @ place - Vector(point)).length < 0.01


@pytest.mark.parametrize(
    "spoil, words",
    [
        (lambda obj, other: setattr(obj.meanvalue.wrap, "target", None), "0 other meshes are selected"),
        (lambda obj, other: setattr(other.data.vertices[7], "co", (float("nan"), 0, 0)), "no numbers"),
        (lambda obj, other: setattr(obj, "scale", (0, 0, 0)) or bpy.context.view_layer.update(), "scaled to nothing"),
    ],
)
def test_what_cannot_be_wrapped_is_told_and_changes_nothing(two, spoil, words):
    obj, other = two
    pick(obj, other)
    spoil(obj, other)
    before = snapshot(obj)
    with pytest.raises(RuntimeError, match=words):
        bpy.ops.meanvalue.wrap()
    assert_same(before, snapshot(obj))


def test_pairs_are_checked_as_they_are_picked(two):
    obj, other = two
    pick(obj, other, [0])
    with pytest.raises(RuntimeError, match="has its place already"):
        bpy.ops.meanvalue.pick_wrap_pairs(vertex=0)
    with pytest.raises(RuntimeError, match="none of the"):
        bpy.ops.meanvalue.pick_wrap_pairs(vertex=10**6)
    assert len(obj.meanvalue.wrap.pairs) == 1


def test_keys_are_carried_in_the_mesh_s_own_proportions_with_what_is_set_on_them(two):
    obj, other = two
    steps.add_group(other, "Top", [vertex.index for vertex in other.data.vertices if vertex.co.z > 0.0])
    rest = np.array([vertex.co for vertex in other.data.vertices])
    factors = {"Wide": (1.3, 1, 1), "Tall": (1, 1, 1.4), "More": (1, 1.2, 1.4), "Still": (1, 1, 1)}
    for name in factors:
        steps.add_key(other, name, rest * factors[name])
    theirs = other.data.shape_keys
    theirs.key_blocks["Tall"].vertex_group, theirs.key_blocks["Tall"].mute = "Top", True
    theirs.key_blocks["More"].relative_key, theirs.key_blocks["More"].slider_max = theirs.key_blocks["Tall"], 2.0
    target = theirs.key_blocks["Wide"].driver_add("value").driver.variables.new().targets[0]
    target.id_type, target.id, target.data_path = 'KEY', theirs, 'key_blocks["More"].value'
    pick(obj, other)
    bpy.ops.meanvalue.wrap()
    theirs.key_blocks["More"].value = 1.0  # what shows by now does not matter
    assert bpy.ops.meanvalue.wrap(carry=True) == {'FINISHED'}
    keys = obj.data.shape_keys
    assert keys.key_blocks.keys() == ["Basis", "Egg", "Wide", "Tall", "More"] and keys.key_blocks["Egg"].value == 0.0
    for name, *size in (("Wide", 2.6, 2, 2), ("Tall", 2, 2, 2.4), ("More", 2, 2.4, 2.4)):  # the other has half the size
        np.testing.assert_allclose(np.ptp(key_points(keys.key_blocks[name]), axis=0), size, atol=0.12)
    assert keys.key_blocks["Tall"].mute and keys.key_blocks["More"].relative_key.name == "Tall"
    assert keys.animation_data.drivers[0].driver.variables[0].targets[0].id == keys
    with steps.refused("all are here already"):
        obj.meanvalue.wrap.keys = "W*, M*"
        bpy.ops.meanvalue.wrap(carry=True)
    wide = keys.key_blocks["Wide"]
    mine, added = steps.add_key(obj, "Mine", 1.1 * key_points(wide), "Wide"), 0.1 * key_points(wide)
    theirs.key_blocks["Wide"].data[1].co.x, obj.meanvalue.wrap.replace = 1.5, True
    bpy.ops.meanvalue.wrap(carry=True)
    assert key_points(wide)[:, 0].max() > 1.35
    np.testing.assert_allclose(key_points(mine) - key_points(wide), added, atol=1e-6)
