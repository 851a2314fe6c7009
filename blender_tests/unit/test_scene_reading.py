# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading an object bit by bit gives what reading it in one go gives, and never what it was before an edit."""

import bpy
import numpy as np
import pytest
from support import handles, meshes, steps


@pytest.fixture
def scene_reading(part):
    return part("bridge.scene_reading")


@pytest.fixture
def small_slices(part, monkeypatch):
    monkeypatch.setattr(part("bridge.vertex_groups"), "SLICE", 4)


def grid_with_region():
    obj = meshes.grid()
    steps.list_anchors(obj, A=[0, 4, 20], B=[24, 23])
    steps.add_group(obj, "Region", range(10, 25))
    obj.meanvalue.roi_group = "Region"
    return obj


def test_in_slices_as_in_one_go(scene_reading, small_slices):
    obj = grid_with_region()
    whole, sliced = scene_reading.SceneReading(obj), scene_reading.SceneReading(obj)
    assert whole.go_on(obj)
    shares = []
    while not sliced.go_on(obj, 0.0):
        shares.append(sliced.share)
    assert len(shares) >= 6 and shares == sorted(shares) and 0.0 < shares[0] < shares[-1] <= 1.0
    assert sliced.is_finished
    assert {name: list(found) for name, found in sliced.members.items()} == {
        "A": [0, 4, 20],
        "B": [23, 24],
        "Region": list(range(10, 25)),
    }
    assert all(np.array_equal(whole.members[name], sliced.members[name]) for name in whole.members)
    assert all(np.array_equal(*pair) for pair in zip(whole.faces, sliced.faces, strict=True))


def test_what_does_not_fit_any_more_is_read_again(part, scene_reading, small_slices):
    obj = grid_with_region()
    gather = part("bridge.scene_input").gather
    reading = scene_reading.SceneReading(obj)
    reading.go_on(obj, 0.0)
    steps.edit_mesh(obj, lambda bm: bm.verts.remove(list(bm.verts)[7]))
    assert not reading.fits(obj)
    assert len(gather(obj, reading).rest) == 24
    reading = scene_reading.SceneReading(obj)
    assert reading.fits(obj)
    obj.meanvalue.roi_group = ""
    assert not reading.fits(obj)
    assert gather(obj, reading).roi.all()


def test_one_reading_for_panel_and_overlay(part, monkeypatch):
    obj = grid_with_region()
    bpy.context.view_layer.update()
    readings, real = part("bridge.shared_readings"), part("bridge.scene_reading").SceneReading
    made = []
    monkeypatch.setattr(readings, "SceneReading", lambda obj: made.append(obj.name) or real(obj))
    part("bridge.object_status").status(obj)
    part("bridge.overlay_data").look(obj)
    assert made == ["Grid"]
    obj.vertex_groups["A"].add([1], 1.0, 'REPLACE')
    bpy.context.view_layer.update()
    assert part("bridge.object_status").status(obj).member_counts["A"] == 4
    assert made == ["Grid", "Grid"]


def test_the_panel_shows_what_it_knows_until_a_big_mesh_is_read(part, monkeypatch):
    obj = grid_with_region()
    bpy.context.view_layer.update()
    status, look = part("bridge.object_status").status, part("bridge.overlay_data").look
    readings = part("bridge.shared_readings")
    finished = readings.finished
    monkeypatch.setattr(readings, "finished", lambda _obj: None)
    assert "being read" in status(obj).text
    assert len(look(obj).points) == 0
    monkeypatch.setattr(readings, "finished", finished)
    assert status(obj).text == "Not bound. Press Bind."
    assert len(look(obj).points) == 5
    obj.vertex_groups["A"].add([1], 1.0, 'REPLACE')
    bpy.context.view_layer.update()
    monkeypatch.setattr(readings, "finished", lambda _obj: None)
    assert status(obj).member_counts["A"] == 3
    assert len(look(obj).points) == 5


def test_only_so_many_objects_are_kept(part):
    readings = part("bridge.shared_readings")
    readings.clear()
    for number in range(readings.MOST + 2):
        readings.finished(meshes.grid(name=f"Grid {number}"))
    assert len(readings._known) == readings.MOST


def test_live_reads_in_slices_and_then_follows(part, small_slices, monkeypatch):
    """As the interface does it: a handler, then the timer."""
    obj, control = handles.tube(live=False)
    follower_module = part("live.follower")
    monkeypatch.setattr(follower_module, "SLICE_SECONDS", 0.0)
    part("bridge.targets").prepare_result(obj)
    follower = follower_module.Follower(obj, hears_itself=True)
    control.location.x += 1.0
    bpy.context.view_layer.update()
    follower.follow(obj)
    assert follower.text == "Live: reading the mesh" and not follower.is_caught_up
    ticks = 0
    while not follower.is_caught_up:
        follower.tick(obj)
        ticks += 1
        assert follower.problem is None and ticks < 100_000
    assert ticks > len(obj.data.vertices) // 4
    assert np.abs(handles.shown(obj)[handles.TOP, 0] - handles.rest(obj)[handles.TOP, 0] - 1.0).max() < 1e-3
    follower.stop()


def test_an_edit_begins_the_reading_anew(part, small_slices, monkeypatch):
    obj, _control = handles.tube(live=False)
    follower_module = part("live.follower")
    monkeypatch.setattr(follower_module, "SLICE_SECONDS", 0.0)
    part("bridge.targets").prepare_result(obj)
    follower = follower_module.Follower(obj, hears_itself=True)
    follower.tick(obj)
    first = follower._scene._reading
    follower.tick(obj)
    assert follower._scene._reading is first
    obj.data.update_tag()
    bpy.context.view_layer.update()
    assert follower.edited(obj) is False
    follower.tick(obj)
    assert follower._scene._reading is not first
    follower.stop()
