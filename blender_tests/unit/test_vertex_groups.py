# SPDX-License-Identifier: GPL-3.0-or-later
"""scene/vertex_groups.py"""

import numpy as np
import pytest
from support import meshes, steps


@pytest.fixture
def members(part):
    return part("scene.vertex_groups").members


def test_several_groups_in_one_pass(members):
    obj = meshes.grid()
    assert members(obj, ["A"]) == {}
    steps.add_group(obj, "A", [3, 1])
    steps.add_group(obj, "Not asked for", [2])
    steps.add_group(obj, "B", [1, 24])
    steps.add_group(obj, "Empty", [])
    found = members(obj, {"A", "B", "Empty", "Gone"})
    assert {name: indices.tolist() for name, indices in found.items()} == {"A": [1, 3], "B": [1, 24], "Empty": []}
    assert found["A"].dtype == np.int32


def test_weights(members):
    obj = meshes.grid()
    steps.add_group(obj, "A", [1], 1.0)
    obj.vertex_groups["A"].add([2], 1e-6, 'REPLACE')
    obj.vertex_groups["A"].add([3], 0.0, 'REPLACE')
    assert members(obj, ["A"])["A"].tolist() == [1, 2]
