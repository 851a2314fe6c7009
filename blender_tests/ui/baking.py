# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake as an artist sees it: progress, Esc that keeps what is done, and what happens to the scene meanwhile."""

import contextlib
import pathlib
import re
import tempfile

import bpy
import numpy as np
from support import installed, interrupting, meshes, tasks
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


def tube():
    return bpy.data.objects["Tube"]


def cache_of(folder):
    return folder / "meanvalue_cache" / "Tube.pc2"


@contextlib.contextmanager
def _chunks_of(frames, waits_at=None, until=lambda execution: execution.pausing):
    """Chunks of so many frames; the one that begins at row `waits_at` begins only once `until(execution)`."""
    plan, solving = installed.part("baking.bridge.plan"), installed.part("baking.bridge.solving")
    chunks, solve = plan.BakePlan.chunks, solving.solve_rows

    def late(binding, bind_input, targets, weights, begin, end, execution, *rest):
        if begin == waits_at:
            yield tasks.Until(lambda: until(execution))
        return (yield from solve(binding, bind_input, targets, weights, begin, end, execution, *rest))

    plan.BakePlan.chunks = lambda self: [
        (begin, min(begin + frames, len(self.times))) for begin in range(0, len(self.times), frames)
    ]
    solving.solve_rows = late
    try:
        yield
    finally:
        plan.BakePlan.chunks, solving.solve_rows = chunks, solve


@contextlib.contextmanager
def _pausing_at(share):
    with interrupting.pausing_at(installed.part("baking.bridge.solving"), share):
        yield


def _text(ui):
    return ui.status_text() or ""


def escape_keeps_what_is_done(ui):
    folder = yield from _tube(ui, live=True)
    before = snapshot(tube())
    with _chunks_of(40, waits_at=80):
        yield from ui.invoke("meanvalue.bake")
        yield from ui.wait_until(lambda: "Baking 'Tube': frame 80 of 120" in _text(ui), "two chunks of three are done")
        assert "Esc: Stop, and keep what is done" in _text(ui)
        assert "left" in _text(ui)
        yield from ui.screenshot("bake_1_progress", amid_work=True)
        yield from ui.key('ESC')
        yield from ui.wait_until(lambda: ui.status_text() is None, "the status bar is given back")
    assert any("80 frames of 120 are kept (1 to 80): Bake again goes on" in line for line in ui.reports()), ui.reports()
    assert_same(before, snapshot(tube()))
    assert not cache_of(folder).exists()
    begun = {path.name: path.stat().st_mtime_ns for path in (folder / "meanvalue_cache" / "Tube.chunks").iterdir()}
    assert len(begun) == 4

    with _chunks_of(40, waits_at=0):  # would wait for ever
        yield from ui.invoke("meanvalue.bake")
        yield from ui.wait_until(lambda: cache_of(folder).exists() and ui.status_text() is None, "it goes on")
    assert any("Baked 'Tube' to '//meanvalue_cache/Tube.pc2'" in line for line in ui.reports()), ui.reports()
    assert len(tube().modifiers) == 1
    assert np.array_equal(played(tube(), [1, 41, 100]), rows(cache_of(folder))[[0, 40, 99]])
    bpy.context.scene.frame_set(1)
    yield from ui.screenshot("bake_2_baked")
    yield from ui.undo()
    assert len(tube().modifiers) == 0


def escape_inside_a_chunk(ui):
    """The first Esc stops after the frames that are being solved, the second at once."""
    folder = yield from _tube(ui)
    twice = []
    with _chunks_of(FRAMES, waits_at=0, until=lambda execution: execution.cancelled and twice):
        yield from ui.invoke("meanvalue.bake")
        yield from ui.wait_until(lambda: "frame 0 of 120" in _text(ui), "it is about to solve")
        yield from ui.key('ESC')
        yield from ui.wait_until(lambda: "Esc: Stop at once" in _text(ui), "it says that it stops")
        yield from ui.screenshot("bake_10_stopping", amid_work=True)
        twice.append(True)
        yield from ui.key('ESC')
        yield from ui.wait_until(lambda: ui.status_text() is None, "the status bar is given back")
    assert any("0 frames of 120 are kept: Bake again goes on" in line for line in ui.reports()), ui.reports()
    with _pausing_at(0.4):
        yield from ui.invoke("meanvalue.bake")
        yield from ui.wait_until(lambda: ui.status_text() is None, "it is stopped on its way")
    (told,) = [line for line in ui.reports() if "kept (" in line]
    kept = int(told.split(" frames of 120")[0].split()[-1])
    assert 0 < kept < FRAMES and not cache_of(folder).exists(), told
    yield from ui.invoke("meanvalue.bake")
    yield from ui.wait_until(lambda: cache_of(folder).exists() and ui.status_text() is None, "it goes on")
    stopped = cache_of(folder).read_bytes()
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
        assert bpy.ops.meanvalue.unbake('EXEC_DEFAULT', delete_files=True) == {'FINISHED'}
        assert bpy.ops.meanvalue.bake('EXEC_DEFAULT') == {'FINISHED'}
    assert cache_of(folder).read_bytes() == stopped


def sampling_is_seen_and_stopped(ui):
    yield from _tube(ui)
    bpy.context.scene.frame_set(7)
    background = installed.part("widgets.background")
    usual = background.SLICE_SECONDS, background.PATIENCE_SECONDS
    background.SLICE_SECONDS = background.PATIENCE_SECONDS = 0.0
    try:
        yield from ui.invoke("meanvalue.bake")
        yield from ui.wait_until(lambda: "sampling the animation" in _text(ui), "the status bar tells of it")
        yield from ui.wait_until(lambda: bpy.context.scene.frame_current > 7, "frames pass")
        yield from ui.screenshot("bake_3_sampling", amid_work=True)
        yield from ui.key('ESC')
        yield from ui.wait_until(lambda: ui.status_text() is None, "the status bar is given back")
    finally:
        background.SLICE_SECONDS, background.PATIENCE_SECONDS = usual
    assert bpy.context.scene.frame_current == 7
    assert len(tube().modifiers) == 0
    assert any("Cancelled" in line or "Stopped" in line for line in ui.reports()), ui.reports()


def an_object_deleted_while_it_is_baked(ui):
    folder = yield from _tube(ui)
    gone = []
    with _chunks_of(40, waits_at=40, until=lambda _execution: bool(gone)):
        yield from ui.invoke("meanvalue.bake")
        yield from ui.wait_until(lambda: "frame 40 of 120" in _text(ui), "a chunk is done")
        bpy.data.objects.remove(tube())
        gone.append(True)
        yield from ui.wait_until(lambda: ui.status_text() is None, "it notices")
    assert any("'Tube' is gone" in line for line in ui.reports()), ui.reports()
    assert not cache_of(folder).exists()


def another_file_while_it_is_sampled(ui):
    yield from _tube(ui)
    background = installed.part("widgets.background")
    usual = background.SLICE_SECONDS, background.PATIENCE_SECONDS
    background.SLICE_SECONDS = background.PATIENCE_SECONDS = 0.0
    try:
        yield from ui.invoke("meanvalue.bake")
        yield from ui.wait_until(lambda: "sampling the animation" in _text(ui), "it samples")
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        yield
        yield
    finally:
        background.SLICE_SECONDS, background.PATIENCE_SECONDS = usual
    assert "Tube" not in bpy.data.objects
    assert installed.part("solver.job")._running == set()
    assert not installed.part("live.engine")._is_held


def a_size_that_hurts_is_asked_about(ui):
    yield from _tube(ui)
    tube().meanvalue.bake.frame_range = 'OWN'
    tube().meanvalue.bake.frame_start, tube().meanvalue.bake.frame_end = 1, 900_000
    yield from ui.invoke("meanvalue.bake")
    yield from ui.screenshot("bake_4_size")
    yield from ui.key('ESC')
    assert ui.status_text() is None
    assert bpy.context.scene.frame_current == 1


def the_panel(ui):
    with _only_the_bake_panel():
        yield from _tube(ui)
        yield from ui.screenshot("bake_5_panel_cache")
        settings = tube().meanvalue.bake
        settings.use_part, settings.frame_range = True, 'OWN'
        yield from ui.screenshot("bake_6_panel_part")
        settings.use_part, settings.target = False, 'SHAPE_KEYS'
        yield from ui.screenshot("bake_7_panel_keys")
        settings.frame_end = -5
        yield from ui.screenshot("bake_8_panel_range_error")
        settings.frame_end, settings.keys = FRAMES, 'EVERY'
        settings.key_step = 10
        with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
            assert bpy.ops.meanvalue.bake('EXEC_DEFAULT') == {'FINISHED'}
        yield from ui.screenshot("bake_9_panel_baked")


@contextlib.contextmanager
def _only_the_bake_panel():
    """Open, and in place of all others: the sidebar has no room for more."""
    panel = installed.part("posing.ui.panel")
    bake = installed.part("baking.panel").MEANVALUE_PT_bake
    usual = bake.bl_options, bake.bl_parent_id
    for cls in (bake, *reversed(panel.CLASSES)):
        bpy.utils.unregister_class(cls)
    bake.bl_options, bake.bl_parent_id = set(), ""
    bpy.utils.register_class(bake)
    try:
        yield
    finally:
        bpy.utils.unregister_class(bake)
        bake.bl_options, bake.bl_parent_id = usual
        for cls in (*panel.CLASSES, bake):
            bpy.utils.register_class(cls)


def another_file_while_a_chunk_is_solved(ui):
    """What is solved of the chunk is kept, as by Esc."""
    frames = 3000
    folder = pathlib.Path(tempfile.mkdtemp(prefix="meanvalue-bake-"))
    obj, _control = animated_tube(frames=frames)
    path = save(folder)
    meshes.activate(obj)
    with _chunks_of(frames):
        yield from ui.invoke("meanvalue.bake")
        yield from ui.wait_until(lambda: re.search(r"frame [1-9][\d,]* of 3,000", _text(ui)), "some are solved")
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        yield
        yield
        assert installed.part("solver.job")._running == set()
        assert not cache_of(folder).exists()
        bpy.ops.wm.open_mainfile(filepath=str(path))
        yield
        with interrupting.pausing_at(installed.part("baking.bridge.solving"), 1.0) as asked:
            yield from ui.invoke("meanvalue.bake")
            yield from ui.wait_until(lambda: cache_of(folder).exists() and ui.status_text() is None, "it goes on")
    assert asked == [(0, frames, True)], "from what was kept"


def another_file_while_a_chunk_takes_too_long(ui):
    """Blender does not wait for it."""
    folder = yield from _tube(ui)
    with _chunks_of(FRAMES, waits_at=0, until=lambda execution: execution.cancelled):
        yield from ui.invoke("meanvalue.bake")
        yield from ui.wait_until(lambda: "frame 0 of 120" in _text(ui), "it is about to solve")
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        yield
        yield
    assert installed.part("solver.job")._running == set()
    assert not cache_of(folder).exists()
