# SPDX-License-Identifier: GPL-3.0-or-later
"""More than one object, and objects that are more than a plain mesh."""

import bpy
import numpy as np
from support import meshes, steps
from support.snapshot import assert_same, snapshot


def duplicate(obj, linked=False):
    copy = obj.copy()
    if not linked:
        copy.data = obj.data.copy()
    bpy.context.collection.objects.link(copy)
    return copy


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


def test_modifiers_and_where_the_object_stands_do_not_matter():
    plain = steps.posed_grid(meshes.grid(name="Plain"))
    steps.solve()
    other = meshes.grid(name="Other")
    other.location, other.rotation_euler, other.scale = (100.0, -20.0, 3.0), (0.3, 1.2, -2.0), (2.0, -0.5, 3.0)
    other.modifiers.new("Subdivision", 'SUBSURF').levels = 2
    other.modifiers.new("Mirror", 'MIRROR')
    bpy.context.view_layer.update()
    steps.posed_grid(other)
    before = snapshot(other)["modifiers"]
    steps.solve()
    assert snapshot(other)["modifiers"] == before
    assert np.array_equal(steps.key_positions(other, "Mean-Value"), steps.key_positions(plain, "Mean-Value"))
