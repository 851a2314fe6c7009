# SPDX-License-Identifier: GPL-3.0-or-later
"""scene/shape_keys.py: reading and writing in single precision, bit by bit."""

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


def test_a_pinned_pose_is_pointed_out(shape_keys):
    obj = meshes.grid()
    steps.add_pose_key(obj)
    obj.show_only_shape_key = True
    notes = shape_keys.write_result(obj, np.zeros((25, 3), np.float32))
    assert "is pinned" in notes[-1]
    assert obj.show_only_shape_key
