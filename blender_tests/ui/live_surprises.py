# SPDX-License-Identifier: GPL-3.0-or-later
"""What happens while the mesh follows: undo, renaming, deleting, other windows' edits, adjusting an operator."""

import time
from unittest import mock

import bpy
import long_work
import numpy as np
from harness import view
from support import handles, installed, meshes, steps, tasks
from support.interface import is_settled


def adjusting_add_handle_takes_the_same_vertices(ui):
    obj = meshes.tube(handles.RINGS, handles.SEGMENTS, "Tube")
    steps.add_group(obj, "Other", range(8, 16))
    obj.data.vertices.foreach_set("select", [v.index in handles.TOP for v in obj.data.vertices])
    for part in (*obj.data.edges, *obj.data.polygons):
        part.select = False
    obj.data.update()
    ui.remember()
    ui.frame_all()
    yield from ui.key('TAB')
    yield from ui.invoke("meanvalue.add_handle")
    made = bpy.data.objects["Tube"].meanvalue.handles
    assert [handle.name for handle in made] == ["Handle"]
    with view.override():
        bpy.context.window_manager.operators[-1].name = "Renamed"
        bpy.ops.ed.undo_redo()
    yield
    made = bpy.data.objects["Tube"].meanvalue.handles
    assert [handle.name for handle in made] == ["Renamed"], [handle.name for handle in made]


def a_mesh_in_another_windows_scene_follows(ui):
    """Timers, and handlers, act in the first window, which shows another scene."""
    obj, control = handles.tube()
    follower, is_in_scene = installed.part("live.roll").follower_of(obj), []
    for name, acts in (("tick", follower.tick), ("follow", follower.follow)):
        look = lambda obj, acts=acts: (is_in_scene.append(obj.name in bpy.context.view_layer.objects), acts(obj))  # noqa: E731
        setattr(follower, name, look)
    with view.override():
        bpy.ops.wm.window_new_main()
    yield
    bpy.context.window_manager.windows[0].scene = bpy.data.scenes.new("Elsewhere")
    yield from ui.pause(1.0)
    for way in (2.0, -1.0):
        place = control.location.x + way
        control.location.x = place
        yield from ui.wait_until(lambda place=place: is_there(obj, place), "the mesh follows")
        yield from ui.pause(1.5)
        assert is_there(obj, place), "and stays, when what is left is done"
    assert len(is_in_scene) > 4 and all(is_in_scene), is_in_scene
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[1]):
        bpy.ops.wm.window_close()


def is_there(obj, place):
    keys = obj.data.shape_keys
    return keys is not None and abs((handles.shown(obj) - handles.rest(obj))[handles.TOP, 0] - place).max() < 1e-3


def disabled_during_a_bind(ui):
    yield from long_work._sheet(ui, live=False)
    yield from ui.invoke("meanvalue.bind")
    yield from ui.wait_until(ui.status_text, "it binds")
    installed.disable()
    yield from ui.pause(1.0)
    text = ui.status_text()
    installed.enable()
    assert text is None, text


def keep_pose_of_a_drag_that_is_not_settled(ui):
    obj, control = yield from _begin(ui)
    with slowly(0.5):
        control.location.x += 1.0
        yield from ui.invoke("meanvalue.keep_pose", name="Kept")
        yield from ui.wait_until(lambda: "Settling" in (ui.status_text() or ""), "the status bar tells of it")
        yield from ui.wait_until(lambda: "Kept" in obj.data.shape_keys.key_blocks, "it is kept")
    kept = np.array([tuple(point.co) for point in obj.data.shape_keys.key_blocks["Kept"].data])
    offset = kept[handles.TOP] - handles.rest(obj)[handles.TOP]
    assert np.abs(offset - (1.0, 0.0, 0.0)).max() < 1e-3, offset[0]


def slowly(seconds):
    """A context in which each solve takes so much longer."""
    session = installed.part("solver.session")
    solve_steps = session.solve_steps

    def late(*arguments, **options):
        outcome = yield from solve_steps(*arguments, **options)
        until = time.monotonic() + seconds
        yield tasks.Until(lambda: time.monotonic() >= until)
        return outcome

    return mock.patch.object(session, "solve_steps", late)


def _begin(ui, make=handles.tube):
    make()
    ui.remember()
    ui.frame_all()
    yield from ui.wait_until(lambda: is_settled(bpy.data.objects["Tube"]), "it is at rest")
    return bpy.data.objects["Tube"], bpy.data.objects["Tube Top"]


def _amid_a_solve(ui, control, act, obj=None):
    """act(), while the mesh follows a move by 1 in X that takes longer; goes on when that is over and `obj` settled."""
    with slowly(0.6):
        control.location.x += 1.0
        yield from ui.pause(0.2)
        act()
        yield from ui.pause(0.8)
        yield from ui.wait_until(lambda: obj is None or is_settled(obj), "it is settled")


def _assert_followed(obj):
    assert abs(_offset(obj)[0] - 1.0) < 1e-3, (_offset(obj), installed.part("live.engine").status(obj))


def _offset(obj):
    return (handles.shown(obj) - handles.rest(obj))[handles.TOP[0]]


def another_mesh_during_a_solve(ui):
    obj, control = yield from _begin(ui)
    other = obj.data.copy()
    for point in other.shape_keys.reference_key.data:
        point.co.y *= 2.0
    for key in other.shape_keys.key_blocks:
        for point, base in zip(key.data, other.shape_keys.reference_key.data, strict=False):
            point.co = base.co
    yield from _amid_a_solve(ui, control, lambda: setattr(obj, "data", other), obj)
    off = handles.shown(obj) - handles.rest(obj)
    assert np.abs(off[:, 1]).max() < 1e-3, np.abs(off).max(axis=0)


def renamed_during_a_solve(ui):
    obj, control = yield from _begin(ui)
    twin = obj.copy()
    twin.data = obj.data.copy()
    bpy.context.collection.objects.link(twin)
    twin.meanvalue.live = False
    for key in twin.data.shape_keys.key_blocks:
        for point in key.data:
            point.co.y *= 2.0
    yield from ui.pause(1.0)

    def rename():
        obj.name, twin.name = "Gone", "Tube"

    yield from _amid_a_solve(ui, control, rename, obj)
    moved = np.abs(handles.shown(twin) - handles.rest(twin)).max()
    assert moved < 1e-5, moved
    _assert_followed(obj)


def undo_during_a_solve(ui):
    obj, control = yield from _begin(ui)
    with slowly(0.6):
        control.location.x += 1.0
        ui.remember()
        yield from ui.pause(0.2)
        yield from ui.undo()
        yield from ui.wait_until(lambda: is_settled(bpy.data.objects["Tube"]), "it is settled")
        obj = bpy.data.objects["Tube"]
        assert abs(_offset(obj)[0]) < 1e-3, _offset(obj)
        yield from ui.redo()
        yield from ui.wait_until(lambda: is_settled(bpy.data.objects["Tube"]), "it is settled")
        _assert_followed(bpy.data.objects["Tube"])


def edited_during_a_solve(ui):
    obj, control = yield from _begin(ui)

    def edit():
        meshes.activate(obj)
        bpy.ops.object.mode_set(mode='EDIT')

    with slowly(0.6):
        yield from _amid_a_solve(ui, control, edit)
        bpy.ops.object.mode_set(mode='OBJECT')
        yield from ui.wait_until(lambda: is_settled(obj), "it is settled")
    _assert_followed(obj)


def deleted_during_a_solve(ui):
    obj, control = yield from _begin(ui)
    yield from _amid_a_solve(ui, control, lambda: bpy.data.objects.remove(obj))
    assert "Tube" not in bpy.data.objects


def a_control_or_a_mesh_deleted_undone_and_redone(ui):
    _obj, control = yield from _begin(ui, handles.three_handles)
    control.location.x += 1.0
    ui.remember()
    yield from ui.wait_until(lambda: abs(_offset(bpy.data.objects["Tube"])[0] - 1.0) < 1e-3, "it follows")
    meshes.activate(bpy.data.objects["Tube Top"])
    ui.remember()
    with view.override():
        bpy.ops.object.delete('EXEC_DEFAULT', True)
    yield from ui.pause(1.0)
    assert "Tube Top" not in bpy.context.view_layer.objects
    yield from ui.undo()
    yield from ui.wait_until(lambda: is_settled(bpy.data.objects["Tube"]), "the control is back")
    obj = bpy.data.objects["Tube"]
    assert obj.meanvalue.handles["Top"].control == bpy.context.view_layer.objects["Tube Top"]
    assert abs(_offset(obj)[0] - 1.0) < 1e-3
    yield from ui.redo()
    yield from ui.pause(1.0)
    assert "Tube Top" not in bpy.context.view_layer.objects
    yield from ui.undo()
    meshes.activate(bpy.data.objects["Tube"])
    ui.remember()
    for _time in range(2):
        with view.override():
            bpy.ops.object.delete('EXEC_DEFAULT', True)
        yield from ui.wait_until(lambda: "Tube Top" not in bpy.data.objects, "its control goes with the mesh")
        yield from ui.undo()
        yield from ui.wait_until(lambda: is_settled(bpy.data.objects["Tube"]), "both are back")
        assert bpy.data.objects["Tube"].meanvalue.handles["Top"].control == bpy.data.objects["Tube Top"]
    yield from ui.redo()
    yield from ui.wait_until(lambda: "Tube Top" not in bpy.data.objects, "gone again")
