# SPDX-License-Identifier: GPL-3.0-or-later
"""Ctrl-C while Blender bakes without a window, and bakes that stop inside a chunk."""

import os
import re
import signal
import time

import bpy
import pytest
from support.baking import animated_tube, bake, curves, rows, save
from support.interrupting import pausing_at

FRAMES = 600


@pytest.mark.skipif(os.name != "posix", reason="no SIGINT")
def test_ctrl_c_keeps_what_is_done_and_bake_goes_on_from_there(tmp_path, part, capfd):
    animated_tube(frames=FRAMES)
    save(tmp_path)
    chunks = tmp_path / "meanvalue_cache" / "Tube.chunks"
    if not bpy.app.background:
        pytest.skip("Esc is for that here")
    child = os.fork()
    if child == 0:  # looks at files only, and ends without touching Blender
        until = time.monotonic() + 120.0
        while not list(chunks.glob("*.json")) and time.monotonic() < until:
            time.sleep(0.02)
        os.kill(os.getppid(), signal.SIGINT)
        os._exit(0)
    heard = []
    with part("workers.interrupts").calling(lambda: heard.append("before and after")):
        assert bpy.ops.meanvalue.bake() == {'CANCELLED'}
        assert heard == []
        os.kill(os.getpid(), signal.SIGINT)
        assert heard == ["before and after"], "what Ctrl-C did before, it does again"
    said = capfd.readouterr().out
    assert "Stopped" in said and f"of {FRAMES:,} are kept (1 to " in said and "): Bake again goes on" in said
    os.waitpid(child, 0)
    kept = sorted(path.name for path in chunks.glob("*.pc2"))
    assert kept and len(kept) < -(-FRAMES // 96)
    stamps = {name: (chunks / name).stat().st_mtime_ns for name in kept}
    solved = []
    solving = part("bake.solving")
    once = solving.solve_rows
    solving.solve_rows = lambda *given, **named: solved.append(given[4]) or once(*given, **named)
    try:
        bake()
    finally:
        solving.solve_rows = once
    assert min(solved) == 96 * len(stamps), "whole chunks are not looked at again"
    assert len(rows(tmp_path / "meanvalue_cache" / "Tube.pc2")) == FRAMES


@pytest.mark.parametrize("step", [1, 2])
def test_stopped_inside_its_only_chunk_it_goes_on_there_to_the_same_bytes(tmp_path, part, capfd, step):
    animated_tube(frames=60 * step)
    save(tmp_path)
    path = tmp_path / "meanvalue_cache" / "Tube.pc2"
    bake(step=step)
    whole = path.read_bytes()
    bpy.ops.meanvalue.unbake(delete_files=True)
    capfd.readouterr()
    kept = []
    for share in (0.1, 0.3, 0.5):
        with pausing_at(part("bake.solving"), share) as asked:
            assert bpy.ops.meanvalue.bake(step=step) == {'CANCELLED'}
        assert asked == [(0, 60, bool(kept))]
        said = capfd.readouterr().out
        kept.append(int(re.search(r"([0-9]+) frames? of 60 (?:is|are) kept \(1\b", said)[1]))
        assert not path.exists()
        if list(path.with_name("Tube.chunks").glob("*.pc2")):  # so quick that it was whole
            pytest.skip("the solver is quicker than the look at it")
        assert len(list(path.with_name("Tube.chunks").glob("*.begun"))) == 1
    assert 0 < kept[0] <= kept[1] <= kept[2] <= 60
    with pausing_at(part("bake.solving"), 1.0) as asked:
        bake(step=step)
    assert asked == [(0, 60, True)]
    assert path.read_bytes() == whole
    assert sorted(each.name for each in path.parent.iterdir()) == ["Tube.pc2", "Tube.pc2.json", "Tube.pc2.svg"]


def test_what_was_begun_is_of_no_use_once_the_motion_is_another(tmp_path, part):
    _obj, control = animated_tube(frames=60)
    save(tmp_path)
    with pausing_at(part("bake.solving"), 0.5):
        assert bpy.ops.meanvalue.bake() == {'CANCELLED'}
    curve = curves(control)[0]
    for point in curve.keyframe_points:
        point.co.y += 0.5
    curve.update()
    with pausing_at(part("bake.solving"), 1.0) as asked:
        bake()
    assert asked == [(0, 60, False)]


def test_what_the_solver_does_not_take_is_solved_from_the_beginning(tmp_path, part, monkeypatch):
    animated_tube(frames=60)
    save(tmp_path)
    path = tmp_path / "meanvalue_cache" / "Tube.pc2"
    with pausing_at(part("bake.solving"), 0.5):
        assert bpy.ops.meanvalue.bake() == {'CANCELLED'}
    store = part("core.chunk_store").ChunkStore
    begun = store.begun
    monkeypatch.setattr(store, "begun", lambda *given: (begun(*given)[0][:-1].copy(), [1]))
    with pausing_at(part("bake.solving"), 1.0) as asked:
        bake()
    assert asked == [(0, 60, True), (0, 60, False)]
    monkeypatch.undo()
    stopped = path.read_bytes()
    bpy.ops.meanvalue.unbake(delete_files=True)
    bake()
    assert path.read_bytes() == stopped
