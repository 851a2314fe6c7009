# SPDX-License-Identifier: GPL-3.0-or-later
"""The buttons of the panel."""

import bpy
import numpy as np
from support import meshes, steps
from support.snapshot import assert_same, snapshot


def _tube():
    """Looked up on every call: references do not survive undo."""
    return bpy.data.objects["Tube"]


def _evaluated(obj):
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    positions = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", positions)
    return positions.reshape(-1, 3)


def bind_and_solve(ui):
    steps.list_anchors(meshes.tube(), Bottom=range(8), Top=range(64, 72))
    ui.frame_all()
    yield from ui.open_tab("Mean-Value")
    ui.remember()
    unbound = snapshot(_tube())

    yield from ui.invoke("meanvalue.bind")
    assert _tube().meanvalue.bound.is_bound
    bound = snapshot(_tube())

    steps.add_pose_key(_tube())
    steps.move(_tube(), range(64, 72), (1.0, 0.0, -0.5))
    ui.remember()
    posed = snapshot(_tube())
    yield from ui.invoke("meanvalue.solve_from_key")
    solved = snapshot(_tube())
    rest = np.array([tuple(vertex.co) for vertex in _tube().data.vertices])
    moved = np.abs(_evaluated(_tube()) - rest).max(axis=1)
    assert np.allclose(moved[64:], 1.0, atol=1e-4) and moved[:8].max() < 1e-4 and moved[8:64].min() > 0.01, moved
    yield from ui.screenshot("solved_by_button")
    assert any("Solved into" in line for line in ui.reports()), ui.reports()

    yield from ui.undo()
    assert_same(posed, snapshot(_tube()))
    yield from ui.redo()
    assert_same(solved, snapshot(_tube()))
    yield from ui.undo()
    yield from ui.undo()
    assert_same(bound, snapshot(_tube()))
    yield from ui.undo()
    assert_same(unbound, snapshot(_tube()))
