# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading an object bit by bit gives what reading it in one go gives, and never what it was before an edit."""

import time
import types

import bpy
import numpy as np
import pytest
from support import handles, meshes, steps


@pytest.fixture
def scene_reading(part):
    return part("scene.scene_reading")


@pytest.fixture
def small_slices(part, monkeypatch):
    monkeypatch.setattr(part("scene.vertex_groups"), "SLICE", 4)


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
    gather = part("posing.bridge.scene_input").gather
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
    module = part("scene.scene_reading")
    made, real = [], module.SceneReading
    monkeypatch.setattr(module, "SceneReading", lambda obj: made.append(obj.name) or real(obj))
    part("posing.bridge.object_status").status(obj)
    part("posing.bridge.overlay_data").look(obj)
    assert made == ["Grid"]
    obj.vertex_groups["A"].add([1], 1.0, 'REPLACE')
    bpy.context.view_layer.update()
    assert part("posing.bridge.object_status").status(obj).member_counts["A"] == 4
    assert made == ["Grid", "Grid"]


@pytest.fixture
def unread(part, monkeypatch):
    """As if the mesh were big: called with True, all readings begin, and none is finished, until called with False."""
    readings = part("scene.shared_readings")
    finished = readings.finished

    def switch(is_unread):
        monkeypatch.setattr(readings, "finished", (lambda _obj: None) if is_unread else finished)

    return switch


def test_panel_and_overlay_show_what_they_know_until_a_big_mesh_is_read(part, unread):
    obj = grid_with_region()
    bpy.context.view_layer.update()
    status, look = part("posing.bridge.object_status").status, part("posing.bridge.overlay_data").look
    unread(True)
    assert "being read" in status(obj).text
    assert len(look(obj).points) == 0
    unread(False)
    assert status(obj).text == "To see the mesh follow, press Live, or Bake."
    assert len(look(obj).points) == 5
    unread(True)
    obj.vertex_groups["A"].add([1], 1.0, 'REPLACE')
    bpy.context.view_layer.update()
    assert status(obj).member_counts["A"] == 3
    assert len(look(obj).points) == 5


@pytest.mark.parametrize("is_removed", [True, False])
def test_the_overlay_of_a_big_mesh_with_a_handle_less(part, unread, is_removed):
    obj = grid_with_region()
    bpy.context.view_layer.update()
    look = part("posing.bridge.overlay_data").look
    assert len(look(obj).points) == 5
    unread(True)
    if is_removed:
        obj.meanvalue.active_handle = 0
        assert bpy.ops.meanvalue.remove_handle() == {'FINISHED'}
    else:
        obj.meanvalue.handles["A"].is_enabled = False
    bpy.context.view_layer.update()
    assert len(look(obj).points) == 5, "what was known"
    unread(False)
    assert len(look(obj).points) == 2


@pytest.fixture
def slow_readings(part, small_slices, monkeypatch):
    """(shared_readings as where something is drawn, a slice at a time; a list that grows with calls for drawing)."""
    readings, drawn = part("scene.shared_readings"), []
    part("scene.object_model").clear()
    timers = types.SimpleNamespace(is_registered=lambda _: False, register=lambda *_, **__: None)
    app = types.SimpleNamespace(background=False, timers=timers)
    monkeypatch.setattr(readings, "SLICE_SECONDS", 0.0)
    monkeypatch.setattr(readings, "bpy", types.SimpleNamespace(data=bpy.data, app=app))
    monkeypatch.setattr(readings.views, "draw_again", lambda: drawn.append(1))
    return readings, drawn


def test_the_timer_reads_on_and_has_the_views_drawn(slow_readings):
    readings, drawn = slow_readings
    obj = grid_with_region()
    assert readings.finished(obj) is None
    while readings._go_on() is not None:
        assert drawn == []
    assert drawn == [1]
    assert readings.finished(obj).is_finished
    assert readings._go_on() is None and drawn == [1], "nobody waits any more"


def test_who_was_told_to_wait_is_drawn_again_when_another_has_finished_the_reading(slow_readings):
    readings, drawn = slow_readings
    obj = grid_with_region()
    assert readings.finished(obj) is None
    readings.known(obj).go_on(obj)
    assert readings._go_on() is None
    assert drawn == [1]


def test_a_mesh_that_is_edited_with_every_frame_is_read_all_the_same(slow_readings, part):
    readings, _drawn = slow_readings
    obj = grid_with_region()
    frames = 0
    while readings.finished(obj) is None:
        part("scene.object_model").edited(obj)
        frames += 1
        assert frames < 20


def test_only_so_many_objects_are_kept(part):
    readings, models = part("scene.shared_readings"), part("scene.object_model")
    models.clear()
    for number in range(models.MOST + 2):
        readings.finished(meshes.grid(name=f"Grid {number}"))
    kept = [model for _key, model in models.known_models() if model.reading is not None]
    assert len(kept) == models.MOST


@pytest.fixture
def slow_follower(part, small_slices, monkeypatch):
    """make(obj): a Follower as the interface has it, that reads a slice of four vertices at a time."""
    module = part("posing.live.follower")
    monkeypatch.setattr(part("live.states"), "SLICE_SECONDS", 0.0)
    made = []

    def make(obj):
        part("posing.bridge.targets").prepare_result(obj)
        made.append(module.Follower(obj, hears_itself=True))
        return made[-1]

    yield make
    for follower in made:
        follower.stop()


def catch_up(follower, obj):
    """Ticks until it is caught up. Returns how often."""
    for ticks in range(100_000):
        if follower.is_caught_up:
            return ticks
        assert follower.tick(obj) is not None
        assert follower.problem is None
    raise AssertionError(follower.text)


def test_live_reads_in_slices_and_then_follows(slow_follower):
    """As the interface does it: a handler, then the timer."""
    obj, control = handles.tube(live=False)
    follower = slow_follower(obj)
    control.location.x += 1.0
    bpy.context.view_layer.update()
    follower.follow(obj)
    assert follower.text == "Live: reading the mesh" and not follower.is_caught_up
    assert catch_up(follower, obj) > len(obj.data.vertices) // 4
    assert np.abs(handles.shown(obj)[handles.TOP, 0] - handles.rest(obj)[handles.TOP, 0] - 1.0).max() < 1e-3


@pytest.fixture
def model_of(part):
    return part("scene.object_model").of


def test_an_edit_begins_the_reading_anew(slow_follower, model_of):
    obj, _control = handles.tube(live=False)
    follower = slow_follower(obj)
    follower.tick(obj)
    first = model_of(obj).reading
    follower.tick(obj)
    assert model_of(obj).reading is first
    obj.data.update_tag()
    bpy.context.view_layer.update()
    follower.tick(obj)
    assert model_of(obj).reading is not first


def test_live_follows_a_mesh_that_is_edited_with_every_frame(slow_follower, model_of):
    obj, control = handles.tube(live=False)
    follower = slow_follower(obj)
    control.location.x += 1.0
    bpy.context.view_layer.update()
    for _frame in range(20):
        model_of(obj).edited()
        follower.follow(obj)
    assert not follower.is_reading


def test_after_a_problem_the_mesh_is_read_without_pauses(slow_follower, part):
    obj, _control = handles.tube(live=False)
    follower = slow_follower(obj)
    meshes.activate(obj)
    bpy.ops.object.mode_set(mode='EDIT')
    follower.follow(obj)
    assert "Edit Mode" in follower.text
    bpy.ops.object.mode_set(mode='OBJECT')
    follower.follow(obj)
    assert follower.text == "Live: reading the mesh"
    assert follower.tick(obj) == part("live.states").TICK_SECONDS


def test_an_edit_that_an_echo_hides_is_found(slow_follower, model_of, part, monkeypatch):
    """And panel and overlay do not go on with what was read before it."""
    obj, control = handles.tube(live=False)
    follower = slow_follower(obj)
    control.location.x += 1.0
    bpy.context.view_layer.update()
    catch_up(follower, obj)
    status = part("posing.bridge.object_status").status
    assert status(obj).member_counts["Top"] == 8
    look = part("posing.bridge.overlay_data").look
    assert len(look(obj).points) == 16
    model = model_of(obj)
    before = model.stamp
    obj.vertex_groups["Top"].remove([handles.TOP[0], handles.TOP[1]])
    assert model.told(obj, part("scene.object_model").Change.KEYS) is False
    assert model.stamp == before and model.reading is None
    while follower.tick(obj) is not None:
        pass
    assert model.stamp != before
    assert "solve" in follower.text and follower.problem is None
    monkeypatch.setattr(part("scene.object_model"), "clock", lambda: time.monotonic() + 1.0)
    assert len(look(obj).points) == 14
    assert status(obj).member_counts["Top"] == 6


def test_what_somebody_else_wrote_is_written_again_by_a_check(slow_follower, model_of, part):
    """An echo hid that the result was written to, and nothing that is bound is another."""
    obj, control = handles.tube(live=False)
    follower = slow_follower(obj)
    control.location.x += 1.0
    bpy.context.view_layer.update()
    while follower.tick(obj) is not None:
        pass
    shown = handles.shown(obj)
    part("scene.shape_keys").write_positions(
        obj.data, obj.data.shape_keys.key_blocks[obj.meanvalue.result_key], (shown + 0.5).astype(np.float32)
    )
    model_of(obj).doubt()
    while follower.tick(obj) is not None:
        pass
    assert follower.is_resting
    assert np.abs(handles.shown(obj) - shown).max() < 1e-3


def test_esc_at_the_moment_when_a_job_ends(part, monkeypatch):
    """The operator's steps without a window. The job is over before anybody looks at it, as it may be."""
    obj, _control = handles.tube(live=False)
    module = part("posing.operators.bind")
    background = part("widgets.background")
    steps_of, job_of = background.BackgroundOperator._all_steps, background.Job
    posing = part("posing.bridge.posing").Posing
    compat = part("compat")

    class Operator:
        _object_name, _object_identity = obj.name, compat.session_key(obj)
        _timer, _job = object(), None
        start_reading = module.MEANVALUE_OT_bind.start_reading
        _read = module.MEANVALUE_OT_bind._read
        before, after = module.MEANVALUE_OT_bind.before, module.MEANVALUE_OT_bind.after
        job_progress, stopped = module.MEANVALUE_OT_bind.job_progress, module.MEANVALUE_OT_bind.stopped

        def _object(self):
            return obj

        def prepare(self, obj, reading):
            return posing.to_bind(obj, reading)

        def finish(self, *_):
            raise AssertionError("it was to be cancelled")

    def cancelled_at_its_end(work):
        job = job_of(work)
        job.wait()
        job.cancel()
        return job

    monkeypatch.setattr(background, "Job", cancelled_at_its_end)
    with pytest.raises(part("errors").CancelledError):
        for _ in steps_of(Operator()):
            pass
