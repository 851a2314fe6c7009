# SPDX-License-Identifier: GPL-3.0-or-later
"""Ctrl-C while Blender bakes without a window."""

import os
import signal
import time

import bpy
import pytest
from support.baking import animated_tube, bake, rows, save

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
    assert "Stopped" in said and f"of {FRAMES:,} are kept: Bake again goes on" in said
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
    assert min(solved) == 96 * len(stamps), "what was kept is not solved again"
    assert len(rows(tmp_path / "meanvalue_cache" / "Tube.pc2")) == FRAMES
