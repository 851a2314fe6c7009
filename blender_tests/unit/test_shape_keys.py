# SPDX-License-Identifier: GPL-3.0-or-later
"""scene/shape_keys.py: reading and writing in single precision, bit by bit."""

import bpy
import numpy as np
import pytest
from support import meshes, steps


@pytest.fixture
def shape_keys(part):
    return part("scene.shape_keys")


def test_rest_is_the_mesh_without_keys_and_the_basis_with(shape_keys):
    obj = meshes.grid()
    own = shape_keys.rest_positions(obj.data)
    assert own.tolist() == [list(vertex.co) for vertex in obj.data.vertices]
    obj.shape_key_add(name="Basis")
    obj.data.vertices[3].co.z = 5.0
    assert np.array_equal(shape_keys.rest_positions(obj.data), own)


def test_the_basis_may_have_any_name_and_place(shape_keys):
    obj = meshes.grid()
    obj.shape_key_add(name="Rest of Them")
    obj.shape_key_add(name="Basis")
    obj.active_shape_key_index = 1
    obj.meanvalue.result_key = "Rest of Them"
    assert "is the rest shape" in shape_keys.result_problem(obj)
    obj.meanvalue.result_key = "Basis"
    assert shape_keys.result_problem(obj) is None


def test_what_is_written_is_read_back_and_shown(shape_keys):
    obj = meshes.grid()
    steps.add_pose_key(obj)
    wanted = np.random.default_rng(1).normal(size=(25, 3)).astype(np.float32)
    shape_keys.write_result(obj, wanted)
    assert np.array_equal(shape_keys.positions(obj.data.shape_keys.key_blocks["Mean-Value"]), wanted)
    bpy.context.view_layer.update()
    shown = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    assert np.abs(np.array([tuple(vertex.co) for vertex in shown.vertices]) - wanted).max() < 1e-6


def test_a_pinned_pose_is_pointed_out(shape_keys):
    obj = meshes.grid()
    steps.add_pose_key(obj)
    obj.show_only_shape_key = True
    notes = shape_keys.write_result(obj, np.zeros((25, 3), np.float32))
    assert "is pinned" in notes[-1]
    assert obj.show_only_shape_key
