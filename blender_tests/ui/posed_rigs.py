# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh on a bent arm: its controls are where it is seen, go along with the bones, and move what is seen."""

import bpy
import numpy as np
from support import rigs
from support.interface import is_settled
from support.rigs import MIDDLE, TOP


def arm():
    return bpy.data.objects["Arm"]


def control(name):
    return arm().meanvalue.handles[name].control


def _settled():
    return is_settled(arm())


def _is_where_seen(name, indices):
    place = np.array(control(name).matrix_world.translation)
    return np.abs(place - rigs.seen(arm())[indices].mean(axis=0)).max() < 1e-3


def a_corrective_at_a_bent_elbow(ui):
    obj, _armature = rigs.arm()
    ui.remember()
    yield from ui.open_tab("Mean-Value")
    rigs.held(obj, "Top", TOP)
    rigs.handle(obj, "Elbow", MIDDLE)
    yield from ui.key('NUMPAD_3')
    ui.frame_all()
    yield from ui.wait_until(_settled, "the mesh is bound")
    for step in range(1, 10):
        rigs.bend(bpy.data.objects["Rig"], 10.0 * step)
        yield
    yield from ui.wait_until(lambda: _is_where_seen("Top", TOP), "the control has gone along")
    yield from ui.wait_until(_settled, "the rig is quiet")
    assert _is_where_seen("Elbow", MIDDLE)
    ui.frame_all()
    yield from ui.screenshot("rig_1_bent")
    ui.remember()
    before = rigs.seen(arm())[MIDDLE]
    place = np.array(control("Elbow").matrix_world.translation)
    yield from ui.drag_by_keys('G', 60, -60)
    yield from ui.wait_until(_settled, "the drag is settled")
    moved = np.array(control("Elbow").matrix_world.translation) - place
    assert np.linalg.norm(moved) > 0.1
    assert np.abs(rigs.seen(arm())[MIDDLE] - before - moved).max() < 1e-3
    yield from ui.screenshot("rig_2_corrected")
    yield from ui.undo()
    yield from ui.wait_until(_settled, "the undo is settled")
    assert np.abs(rigs.seen(arm())[MIDDLE] - before).max() < 2e-3
    yield from ui.redo()
    yield from ui.wait_until(_settled, "the redo is settled")
    assert np.abs(rigs.seen(arm())[MIDDLE] - before - moved).max() < 2e-3
    rigs.bend(bpy.data.objects["Rig"], 0.0)
    yield from ui.wait_until(_settled, "the arm is straight")
    yield from ui.screenshot("rig_3_straight")


def a_rig_at_rest_costs_nothing(ui):
    """Live on a bent rig before anything is posed: measuring what the rig does is no reason to measure it again."""
    obj, _armature = rigs.arm()
    ui.remember()
    yield from ui.open_tab("Mean-Value")
    rigs.handle(obj, "Top", TOP)
    rigs.bend(bpy.data.objects["Rig"], 60.0)
    yield from ui.wait_until(_settled, "the mesh is bound")
    yield from ui.pause(1.5)
    evaluated = []

    def count(_scene, _depsgraph):
        evaluated.append(_settled())

    bpy.app.handlers.depsgraph_update_post.append(count)
    yield from ui.pause(2.0)
    bpy.app.handlers.depsgraph_update_post.remove(count)
    assert len(evaluated) == 0
    assert _settled()
