# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles that come and go on one mesh: what was bound before is used again, and nothing in the result tells."""

import bpy
import numpy as np
import pytest
from support import meshes, steps


@pytest.fixture
def session(part):
    return part("solver.session")


@pytest.fixture
def tube():
    return meshes.tube(rings=30, segments=12)


def test_a_handle_more_gives_what_a_fresh_session_gives(tube, session, monkeypatch):
    steps.list_anchors(tube, Low=range(12), High=range(348, 360))
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    steps.add_pose_key(tube)
    pose = tube.active_shape_key.name
    known = []
    bind_steps = session.bind_steps

    def noted(*arguments, **options):
        known.append(options.get("known"))
        return bind_steps(*arguments, **options)

    monkeypatch.setattr(session, "bind_steps", noted)
    steps.list_anchors(tube, Middle=[180])
    steps.move(tube, [180], (0.3, 0.1, 0.0), tube.data.shape_keys.key_blocks[pose])
    steps.solve()
    again = steps.key_positions(tube, tube.meanvalue.result_key)
    session.clear()
    steps.solve()
    assert np.array_equal(again, steps.key_positions(tube, tube.meanvalue.result_key))
    assert [entry is not None for entry in known] == [True, False]


def test_another_rest_shape_or_region_is_not_bound_again_from_it(tube, session, part):
    steps.list_anchors(tube, Low=range(12), High=range(348, 360))
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    gather = part("posing.bridge.scene_input").gather
    assert session.earlier(gather(tube)) is not None
    tube.data.vertices[100].co.x += 0.1
    assert session.earlier(gather(tube)) is None
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    assert session.earlier(gather(tube)) is not None
