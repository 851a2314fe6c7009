# SPDX-License-Identifier: GPL-3.0-or-later
"""Ctrl-C while Blender bakes without a window, and bakes that stop inside a chunk."""

import re

import bpy
import pytest
from support.baking import animated_tube, bake, curves, save
from support.interrupting import pausing_at

FRAMES = 600


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
        with pausing_at(part("baking.bridge.solving"), share) as asked:
            assert bpy.ops.meanvalue.bake(step=step) == {'CANCELLED'}
        assert asked == [(0, 60, bool(kept))]
        said = capfd.readouterr().out
        kept.append(int(re.search(r"([0-9]+) frames? of 60 (?:is|are) kept \(1\b", said)[1]))
        assert not path.exists()
        if list(path.with_name("Tube.chunks").glob("*.pc2")):  # so quick that it was whole
            pytest.skip("the solver is quicker than the look at it")
        assert len(list(path.with_name("Tube.chunks").glob("*.begun"))) == 1
    assert 0 < kept[0] <= kept[1] <= kept[2] <= 60
    with pausing_at(part("baking.bridge.solving"), 1.0) as asked:
        bake(step=step)
    assert asked == [(0, 60, True)]
    assert path.read_bytes() == whole
    assert sorted(each.name for each in path.parent.iterdir()) == ["Tube.pc2", "Tube.pc2.json"]


def test_what_was_begun_is_of_no_use_once_the_motion_is_another(tmp_path, part):
    _obj, control = animated_tube(frames=60)
    save(tmp_path)
    with pausing_at(part("baking.bridge.solving"), 0.5):
        assert bpy.ops.meanvalue.bake() == {'CANCELLED'}
    curve = curves(control)[0]
    for point in curve.keyframe_points:
        point.co.y += 0.5
    curve.update()
    with pausing_at(part("baking.bridge.solving"), 1.0) as asked:
        bake()
    assert asked == [(0, 60, False)]


def test_what_the_solver_does_not_take_is_solved_from_the_beginning(tmp_path, part, monkeypatch):
    animated_tube(frames=60)
    save(tmp_path)
    path = tmp_path / "meanvalue_cache" / "Tube.pc2"
    with pausing_at(part("baking.bridge.solving"), 0.5):
        assert bpy.ops.meanvalue.bake() == {'CANCELLED'}
    store = part("baking.core.chunk_store").ChunkStore
    begun = store.begun
    monkeypatch.setattr(store, "begun", lambda *given: (begun(*given)[0][:-1].copy(), [1]))
    with pausing_at(part("baking.bridge.solving"), 1.0) as asked:
        bake()
    assert asked == [(0, 60, True), (0, 60, False)]
    monkeypatch.undo()
    stopped = path.read_bytes()
    bpy.ops.meanvalue.unbake(delete_files=True)
    bake()
    assert path.read_bytes() == stopped
