# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles that come and go on one mesh: what was bound before is used again, and nothing in the result tells."""

import bpy
import numpy as np
import pytest
from support import meshes, steps


@pytest.fixture
def tube():
    return meshes.tube(rings=30, segments=12)


def test_a_handle_more_gives_what_a_fresh_session_gives(tube, part):
    steps.list_anchors(tube, Low=range(12), High=range(348, 360))
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    steps.add_pose_key(tube)
    pose = tube.active_shape_key.name
    steps.list_anchors(tube, Middle=[180])
    steps.move(tube, [180], (0.3, 0.1, 0.0), tube.data.shape_keys.key_blocks[pose])
    steps.solve()
    again = steps.key_positions(tube, tube.meanvalue.result_key)
    part("solver.session").cache.clear()
    steps.solve()
    assert np.array_equal(again, steps.key_positions(tube, tube.meanvalue.result_key))
