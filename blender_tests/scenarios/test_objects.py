# SPDX-License-Identifier: GPL-3.0-or-later
"""More than one object, and objects that are more than a plain mesh."""

import bpy
import numpy as np
import pytest
from support import meshes, steps
from support.snapshot import assert_same, snapshot


def duplicate(obj, linked=False):
    copy = obj.copy()
    if not linked:
        copy.data = obj.data.copy()
    bpy.context.collection.objects.link(copy)
    return copy


def test_two_objects_are_independent():
    first = steps.posed_grid(meshes.grid(name="First"))
    second = meshes.tube(name="Second")
    steps.list_anchors(second, Bottom=range(8), Top=range(64, 72))
    bpy.ops.meanvalue.bind()
    steps.add_pose_key(second)
    steps.move(second, range(64, 72), (1.0, 0.0, 0.0))
    before = snapshot(first, without=("datablocks",))
    steps.solve()
    assert_same(before, snapshot(first, without=("datablocks",)))
    meshes.activate(first)
    before = snapshot(second, without=("datablocks",))
    steps.solve()
    assert_same(before, snapshot(second, without=("datablocks",)))


def test_a_duplicate_is_bound_and_solves_on_its_own():
    obj = steps.posed_grid(meshes.grid())
    copy = duplicate(obj)
    assert steps.is_bound(copy)
    meshes.activate(copy)
    steps.move(copy, [24], (0.0, 0.0, 1.0))
    before = snapshot(obj, without=("datablocks",))
    steps.solve()
    assert_same(before, snapshot(obj, without=("datablocks",)))
    assert "Mean-Value" in copy.data.shape_keys.key_blocks


def test_a_mesh_of_two_objects_is_solved_with_a_note(capfd):
    obj = steps.posed_grid(meshes.grid())
    other = duplicate(obj, linked=True)
    capfd.readouterr()
    steps.solve()
    assert "shared" in capfd.readouterr().out
    meshes.activate(other)
    assert other.data.shape_keys.key_blocks.keys() == ["Basis", "Pose", "Mean-Value"]


def test_modifiers_are_left_out_and_left_alone():
    plain = steps.posed_grid(meshes.grid(name="Plain"))
    steps.solve()
    modified = meshes.grid(name="Modified")
    modified.modifiers.new("Subdivision", 'SUBSURF').levels = 2
    modified.modifiers.new("Mirror", 'MIRROR')
    steps.posed_grid(modified)
    before = snapshot(modified)["modifiers"]
    steps.solve()
    assert snapshot(modified)["modifiers"] == before
    assert np.array_equal(steps.key_positions(modified, "Mean-Value"), steps.key_positions(plain, "Mean-Value"))


def test_where_the_object_stands_does_not_matter():
    plain = steps.posed_grid(meshes.grid(name="Plain"))
    steps.solve()
    placed = meshes.grid(name="Placed")
    placed.location = (100.0, -20.0, 3.0)
    placed.rotation_euler = (0.3, 1.2, -2.0)
    placed.scale = (2.0, -0.5, 3.0)
    bpy.context.view_layer.update()
    steps.posed_grid(placed)
    steps.solve()
    assert np.array_equal(steps.key_positions(placed, "Mean-Value"), steps.key_positions(plain, "Mean-Value"))


def test_names_with_odd_characters():
    obj = meshes.grid(name="100%s {0} \u00e4\u4e2d")
    steps.list_anchors(obj, **{"50% {x}": [0, 4, 20], "\u00e9paule": [24]})
    obj.meanvalue.result_key = "R\u00e9sultat %d"
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    steps.add_pose_key(obj)
    steps.solve()
    assert "R\u00e9sultat %d" in obj.data.shape_keys.key_blocks
    bpy.ops.object.mode_set(mode='EDIT')
    with steps.refused("'100%s {0} \u00e4\u4e2d' is in Edit Mode"):
        bpy.ops.meanvalue.solve_from_key()


@pytest.mark.parametrize("loose_parts", ["follow", "stay"])
def test_loose_vertices_follow_or_stay(loose_parts):
    obj = meshes.grid()
    steps.edit_mesh(obj, lambda bm: bm.verts.new((9.0, 9.0, 9.0)))
    obj.meanvalue.loose_parts = loose_parts
    steps.posed_grid(obj)
    steps.solve()
    rest, result = steps.key_positions(obj, "Basis"), steps.key_positions(obj, "Mean-Value")
    assert np.isfinite(result).all()
    assert np.array_equal(rest[25], result[25]) == (loose_parts == "stay")
