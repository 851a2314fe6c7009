# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles dragged with the mouse: the mesh follows, and everything can be taken back."""

import contextlib

import bpy
import numpy as np
from harness import view
from support import handles, meshes, steps
from support.handles import SEGMENTS, TOP, is_at_rest, rest, shown
from support.interface import is_settled


def control():
    return handles.again().meanvalue.handles["Top"].control


def settled():
    return is_settled(handles.again())


def _select(ui, indices):
    """In Edit Mode, as if by clicks."""
    obj = handles.again()
    meshes.activate(obj)
    for vertex in obj.data.vertices:
        vertex.select = vertex.index in indices
    for polygon in obj.data.polygons:
        polygon.select = False
    for edge in obj.data.edges:
        edge.select = False
    yield from ui.move_mouse(*ui.project(obj.location))
    yield from ui.key('TAB')
    assert handles.again().mode == 'EDIT'


def _set_up(ui):
    """A pinned tube with a handle, made by the artist's own steps, and a look along y."""
    meshes.tube(handles.RINGS, SEGMENTS)
    ui.remember()
    yield from ui.open_tab("Mean-Value")
    yield from _select(ui, set(handles.BOTTOM))
    yield from ui.invoke("meanvalue.add_handle", pin=True)
    yield from _select(ui, set(TOP))
    yield from ui.screenshot("live_1_selected_in_edit_mode")
    yield from ui.invoke("meanvalue.add_handle", name="Top")
    assert handles.again().mode == 'OBJECT' and bpy.context.view_layer.objects.active == control()
    yield from ui.key('NUMPAD_1')
    ui.frame_all()
    yield from ui.wait_until(settled, "the mesh is bound and at rest")


def drag_a_handle(ui):
    yield from _set_up(ui)
    yield from ui.screenshot("live_2_handle_added")
    followed = []

    def look(_step):
        yield from ui.wait_until(
            lambda: handles.follows(handles.again(), np.array(control().location) - start), "the mesh follows mid-drag"
        )
        followed.append(float(np.abs(meshes.seen(handles.again()) - rest(handles.again())).max()))

    start = np.array(control().location)
    yield from ui.drag_by_keys('G', 160, -60, between=look, end=None)
    assert followed == sorted(followed) and followed[0] > 0.05, followed
    yield from ui.screenshot("live_3_mid_drag", amid_work=True)
    yield from ui.key('RET')
    yield from ui.wait_until(settled, "the drag is settled")
    dropped = shown(handles.again())
    assert not is_at_rest(handles.again())
    yield from ui.screenshot("live_4_confirmed")

    yield from ui.undo()
    yield from ui.wait_until(settled, "the undo is settled")
    assert is_at_rest(handles.again(), 1e-3), np.abs(shown(handles.again()) - rest(handles.again())).max()
    yield from ui.screenshot("live_5_undone")
    yield from ui.redo()
    yield from ui.wait_until(settled, "the redo is settled")
    assert np.abs(shown(handles.again()) - dropped).max() < 5e-3

    yield from ui.key('R')
    yield from ui.type("y60")
    yield from ui.key('RET')
    yield from ui.wait_until(settled, "the turn is settled")
    turned = shown(handles.again())
    assert np.abs(turned[TOP] - dropped[TOP]).max() > 0.5
    yield from ui.screenshot("live_6_turned")

    yield from ui.drag_by_keys('G', 100, 100, end='ESC')
    yield from ui.wait_until(settled, "the mesh is back after Esc")
    assert np.abs(shown(handles.again()) - turned).max() < 5e-3

    yield from ui.invoke("meanvalue.reset_handles")
    yield from ui.wait_until(settled, "the handles are reset")
    assert is_at_rest(handles.again(), 1e-2)
    yield from ui.undo()
    yield from ui.wait_until(settled, "the reset is undone")
    assert np.abs(shown(handles.again()) - turned).max() < 5e-3
    yield from ui.invoke("meanvalue.keep_pose", name="Lean")
    yield from ui.wait_until(settled, "the pose is kept")
    assert handles.again().data.shape_keys.key_blocks["Lean"].value == 1.0 and is_at_rest(handles.again(), 1e-2)
    with view.override(), contextlib.suppress(RuntimeError):  # refused, which tells Blender of no change
        bpy.ops.meanvalue.apply_pose('EXEC_DEFAULT', True)
        raise AssertionError("a pose at rest was applied")
    yield from ui.wait_until(settled, "it is live after what was refused")


def undo_of_adding_a_handle(ui):
    yield from _set_up(ui)
    assert len(handles.again().meanvalue.handles) == 2
    yield from ui.undo()
    assert [line.name for line in handles.again().meanvalue.handles] == ["Pin"]
    assert [obj.name for obj in bpy.data.objects] == ["Tube"]
    assert steps.held(handles.again(), "Pin") == list(handles.BOTTOM)
    yield from ui.redo()
    assert len(handles.again().meanvalue.handles) == 2 and control() is not None
    yield from ui.wait_until(settled, "it is live again")
    yield from ui.undo()
    yield from ui.undo()
    assert handles.again().mode == 'EDIT'
    yield from ui.key('TAB')


def playback(ui):
    _obj, handle = handles.tube()
    handle.keyframe_insert("location", frame=1)
    handle.location.x += 4.0
    handle.keyframe_insert("location", frame=40)
    bpy.context.scene.frame_end = 40
    bpy.context.scene.frame_set(1)
    ui.remember()
    yield from ui.key('NUMPAD_1')
    ui.frame_all()
    yield from ui.wait_until(settled, "it is at rest")
    yield from ui.key('SPACE')
    yield from ui.wait_until(lambda: not is_at_rest(handles.again(), 0.1), "playback moves the mesh")
    yield from ui.key('SPACE')
    yield from ui.wait_until(settled, "it has stopped")
    expected = rest(handles.again())[TOP, 0] + control().matrix_world.translation.x
    assert np.abs(shown(handles.again())[TOP, 0] - expected).max() < 1e-3
