# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake as an artist sees it: progress, Esc that keeps what is done, and what happens to the scene meanwhile."""

import contextlib
import pathlib
import tempfile
from unittest import mock

import bpy
import numpy as np
from support import handles, installed, meshes, tasks
from support.baking import animated_tube, played, rows, save
from support.snapshot import assert_same, snapshot

FRAMES = 120


def _tube(ui, live=False):
    """An animated tube in a saved file, seen in the opened tab. Returns the folder."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="meanvalue-bake-"))
    obj, _control = animated_tube(frames=FRAMES, live=live)
    save(folder)
    meshes.activate(obj)
    ui.remember()
    ui.frame_all()
    yield from ui.open_tab("Mean-Value")
    return folder


def cache_of(folder):
    return folder / "meanvalue_cache" / "scene" / "Tube.pc2"


@contextlib.contextmanager
def _chunks_of(frames, waits_at, until=lambda execution: execution.cancelled):
    """Chunks of so many frames; the one that begins at row `waits_at` begins only once `until(execution)`."""
    clips = installed.part("baking.bridge.clips")
    solve = clips.HandleClip.solve_rows

    def late(self, binding, begin, end, execution, *rest):
        if begin == waits_at:
            yield tasks.Until(lambda: until(execution))
        return (yield from solve(self, binding, begin, end, execution, *rest))

    with mock.patch.object(clips, "CHUNK_FRAMES", frames), mock.patch.object(clips.HandleClip, "solve_rows", late):
        yield


def _each_step_is_seen():
    """A context."""
    background = installed.part("widgets.background")
    return mock.patch.multiple(background, SLICE_SECONDS=0.0, PATIENCE_SECONDS=0.0)


def _text(ui):
    return ui.status_text() or ""


def escape_keeps_what_is_done(ui):
    folder = yield from _tube(ui, live=True)
    before = snapshot(handles.again())
    with _chunks_of(40, waits_at=80):
        yield from ui.invoke("meanvalue.bake")
        yield from ui.wait_until(lambda: "Baking 'Tube': frame 80 of 120" in _text(ui), "two chunks of three are done")
        yield from ui.screenshot("bake_1_progress", amid_work=True)
        yield from ui.key('ESC')
        yield from ui.wait_until(lambda: ui.status_text() is None, "the status bar is given back")
    assert_same(before, snapshot(handles.again()))
    assert not cache_of(folder).exists()
    assert len(list((folder / "meanvalue_cache" / "scene").glob("Tube.pc2.*.part"))) == 1

    with _chunks_of(40, waits_at=0):  # would wait for ever
        yield from ui.invoke("meanvalue.bake")
        yield from ui.wait_until(lambda: cache_of(folder).exists() and ui.status_text() is None, "it goes on")
    assert len(handles.again().modifiers) == 1
    assert np.array_equal(played(handles.again(), [1, 41, 100]), rows(cache_of(folder))[[0, 40, 99]])
    bpy.context.scene.frame_set(1)
    yield from ui.screenshot("bake_2_baked")
    yield from ui.undo()
    assert len(handles.again().modifiers) == 0


def sampling_is_seen_and_stopped(ui):
    yield from _tube(ui)
    bpy.context.scene.frame_set(7)
    with _each_step_is_seen():
        yield from ui.invoke("meanvalue.bake")
        yield from ui.wait_until(lambda: "sampling the animation" in _text(ui), "the status bar tells of it")
        yield from ui.wait_until(lambda: bpy.context.scene.frame_current > 7, "frames pass")
        yield from ui.screenshot("bake_3_sampling", amid_work=True)
        yield from ui.key('ESC')
        yield from ui.wait_until(lambda: ui.status_text() is None, "the status bar is given back")
    assert bpy.context.scene.frame_current == 7
    assert len(handles.again().modifiers) == 0


def an_object_deleted_while_it_is_baked(ui):
    folder = yield from _tube(ui)
    gone = []
    with _chunks_of(40, waits_at=40, until=lambda _execution: bool(gone)):
        yield from ui.invoke("meanvalue.bake")
        yield from ui.wait_until(lambda: "frame 40 of 120" in _text(ui), "a chunk is done")
        bpy.data.objects.remove(handles.again())
        gone.append(True)
        yield from ui.wait_until(lambda: ui.status_text() is None, "it notices")
    assert any("'Tube' is gone" in line for line in ui.reports()), ui.reports()
    assert not cache_of(folder).exists()


def another_file_while_a_chunk_is_solved(ui):
    """Blender does not wait for it."""
    folder = yield from _tube(ui)
    with _chunks_of(FRAMES, waits_at=0):
        yield from ui.invoke("meanvalue.bake")
        yield from ui.wait_until(lambda: "frame 0 of 120" in _text(ui), "it is about to solve")
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        yield
        yield
    assert installed.part("solver.job")._running == set()
    assert not cache_of(folder).exists()


def a_size_that_hurts_is_asked_about(ui):
    yield from _tube(ui)
    handles.again().meanvalue.bake.frame_range = 'OWN'
    handles.again().meanvalue.bake.frame_start, handles.again().meanvalue.bake.frame_end = 1, 900_000
    yield from ui.invoke("meanvalue.bake")
    yield from ui.screenshot("bake_4_size")
    yield from ui.key('ESC')
    assert ui.status_text() is None
    assert bpy.context.scene.frame_current == 1
