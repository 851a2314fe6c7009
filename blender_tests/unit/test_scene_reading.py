# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading an object bit by bit gives what reading it in one go gives, and never what it was before an edit."""

import bpy
import numpy as np
import pytest
from support import handles, meshes, steps
from support.interface import interface


@pytest.fixture
def scene_reading(part):
    return part("posing.bridge.scene_reading")


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


@pytest.fixture
def unread(part, monkeypatch):
    """As if the mesh were big: called with True, all readings begin, and none is finished, until called with False."""
    readings = part("scene.shared_readings")
    finished = readings.finished

    def switch(is_unread):
        monkeypatch.setattr(readings, "finished", (lambda *_: None) if is_unread else finished)

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
def finished(part, small_slices, monkeypatch):
    """(finished(obj) as where something is drawn, a slice at a time; the timers; a list that grows with drawing)."""
    readings, drawn = part("scene.shared_readings"), []
    part("scene.object_model").clear()
    monkeypatch.setattr(readings, "SLICE_SECONDS", 0.0)
    monkeypatch.setattr(readings.views, "draw_again", lambda *_: drawn.append(1))
    kind = part("posing.bridge.scene_input").HandleReading
    with interface() as timers:
        yield (lambda obj: readings.finished(obj, kind)), timers, drawn


def test_the_timer_reads_on_and_has_the_views_drawn(finished):
    finished, timers, drawn = finished
    obj = grid_with_region()
    drawn.clear()
    assert finished(obj) is None and drawn == []
    assert timers.run() > 5
    assert drawn == [1]
    assert finished(obj).faces is not None
    assert timers.run() == 0 and drawn == [1], "nobody waits any more"


def test_a_mesh_that_is_edited_with_every_frame_is_read_all_the_same(finished, part):
    finished, _timers, _drawn = finished
    obj = grid_with_region()
    frames = 0
    while finished(obj) is None:
        part("scene.object_model").edited(obj)
        frames += 1
        assert frames < 20


def test_only_so_many_objects_are_kept(part):
    scene_input, models = part("posing.bridge.scene_input"), part("scene.object_model")
    models.clear()
    for number in range(models.MOST + 2):
        scene_input.model(meshes.grid(name=f"Grid {number}")).read_on(bpy.context.object)
    kept = [model for _key, model in models.known_models() if model.reading is not None]
    assert len(kept) == models.MOST


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
        _timer, _job, _steps = object(), None, object()
        _beside_the_interface = background.BackgroundOperator._beside_the_interface
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
