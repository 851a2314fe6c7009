# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh that takes its time: progress, Esc, and a drag that is never waited for."""

from unittest import mock

import bpy
import numpy as np
from support import handles, installed, steps, tasks
from support.interface import is_settled
from support.snapshot import assert_same, snapshot

COLUMNS = 300  # and as many rows: 90,000 vertices bind for seconds


def _sheet(ui, live):
    """A big sheet with a pin along one edge and a handle along the other, seen from the front."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=COLUMNS - 1, y_subdivisions=COLUMNS - 1, size=4.0)
    obj = bpy.context.object
    obj.name = "Sheet"
    count = len(obj.data.vertices)
    steps.add_handle(obj, "Low", range(COLUMNS), pin=True)
    steps.add_handle(obj, "High", range(count - COLUMNS, count), live=live)
    ui.remember()
    ui.frame_all()
    yield from ui.open_tab("Mean-Value")


def sheet():
    return bpy.data.objects["Sheet"]


def control():
    return sheet().meanvalue.handles["High"].control


def escape_during_a_bind(ui):
    yield from _sheet(ui, live=False)
    before = snapshot(sheet())
    yield from ui.invoke("meanvalue.bind")
    yield from ui.wait_until(ui.status_text, "the status bar tells of the bind")
    yield from ui.screenshot("long_1_binding", amid_work=True)
    assert "Esc: Cancel" in ui.status_text()
    yield from ui.key('ESC')
    yield from ui.wait_until(lambda: ui.status_text() is None, "the status bar is given back")
    assert_same(before, snapshot(sheet()))
    assert any("Cancelled" in line for line in ui.reports()), ui.reports()

    yield from ui.invoke("meanvalue.bind")
    yield from ui.wait_until(lambda: sheet().meanvalue.bound.is_bound, "it binds when it is let")
    yield from ui.wait_until(lambda: ui.status_text() is None, "the status bar is given back")
    yield from ui.undo()
    assert not sheet().meanvalue.bound.is_bound


def escape_during_a_solve(ui):
    yield from _sheet(ui, live=False)
    yield from ui.invoke("meanvalue.bind")
    yield from ui.wait_until(lambda: sheet().meanvalue.bound.is_bound, "it is bound")
    control().location.z += 1.0
    control().rotation_mode = 'XYZ'
    control().rotation_euler.x = 2.0
    ui.remember()
    before = snapshot(sheet())
    with _solving_until_cancelled():
        yield from ui.invoke("meanvalue.solve")
        yield from ui.wait_until(lambda: "Solving 'Sheet'" in (ui.status_text() or ""), "the status bar tells of it")
        yield from ui.key('ESC')
        yield from ui.wait_until(lambda: ui.status_text() is None, "the status bar is given back")
    assert_same(before, snapshot(sheet()))
    yield from ui.invoke("meanvalue.solve")
    yield from ui.wait_until(lambda: sheet().data.shape_keys, "it is solved when it is let")


def _solving_until_cancelled():
    """A context. The solver is quicker than the interface draws here: let it begin only once it was cancelled."""
    session = installed.part("solver.session")
    solve_steps = session.solve_steps

    def late(*arguments, execution, **options):
        yield tasks.Until(lambda: execution.cancelled)
        return (yield from solve_steps(*arguments, execution=execution, **options))

    return mock.patch.object(session, "solve_steps", late)


def a_slow_drag_ends_with_the_answer(ui):
    yield from _sheet(ui, live=True)
    yield from ui.wait_until(lambda: is_settled(sheet()), "it is bound")
    yield from ui.drag_by_keys('G', 80, 120, steps=8, end=None)
    yield from ui.screenshot("long_2_slow_drag", amid_work=True)
    yield from ui.key('RET')
    yield from ui.wait_until(lambda: is_settled(sheet()), "the drag is settled by Blender's own timer")
    offset = (handles.shown(sheet()) - handles.rest(sheet()))[-COLUMNS:]
    wanted = np.array(control().location) - (0.0, 2.0, 0.0)
    assert np.abs(offset - wanted).max() < 1e-3, (offset[0], wanted)
