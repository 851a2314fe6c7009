# SPDX-License-Identifier: GPL-3.0-or-later
"""posing/bridge/object_status.py with the handlers that tell it what was edited."""

import time

import bpy
import pytest
from support import meshes, steps
from support.snapshot import assert_same, snapshot


@pytest.fixture
def object_status(part):
    return part("posing.bridge.object_status")


@pytest.fixture
def object_model(part):
    return part("scene.object_model")


@pytest.fixture
def reads(object_status, monkeypatch):
    """Counts how often a mesh is read."""
    counted = []
    real = object_status._read

    def read(obj, reading):
        counted.append(obj.name)
        return real(obj, reading)

    monkeypatch.setattr(object_status, "_read", read)
    return counted


def update():
    bpy.context.view_layer.update()


def test_texts(object_status):
    obj = meshes.grid()
    status = object_status.status(obj)
    assert (status.state.name, "There are no handles yet" in status.text) == ("PROBLEM", True)
    steps.list_anchors(obj, A=[0, 4, 20], B=[24])
    update()
    status = object_status.status(obj)
    assert (status.state.name, status.text) == ("UNBOUND", "To see the mesh follow, press Live, or Bake.")
    assert status.member_counts == {"A": 3, "B": 1}
    bpy.ops.meanvalue.bind()
    status = object_status.status(obj)
    assert status.state.name == "BOUND"
    assert "25 vertices, 4 held, 21 free" in status.text
    obj.vertex_groups["A"].add([2], 1.0, 'REPLACE')
    update()
    status = object_status.status(obj)
    assert status.state.name == "BOUND"  # the next pose takes it in
    assert status.member_counts == {"A": 4, "B": 1}
    obj.vertex_groups.remove(obj.vertex_groups["B"])
    status = object_status.status(obj)
    assert status.state.name == "PROBLEM"
    assert "no vertex group 'B'" in status.text
    assert status.member_counts == {"A": 4}
    bpy.ops.meanvalue.unbind()
    bpy.ops.meanvalue.remove_handle()
    assert object_status.status(obj).state.name == "UNBOUND"


def test_a_mesh_is_read_once_until_it_is_edited(object_status, reads):
    obj = steps.bound_grid(meshes.grid())
    update()
    for _ in range(5):
        object_status.status(obj)
    assert reads == ["Grid"]
    obj.location.x += 1.0
    update()
    object_status.status(obj)
    assert reads == ["Grid"]
    obj.data.vertices[3].co.z += 1.0
    obj.data.update()
    update()
    assert object_status.status(obj).state.name == "STALE"
    object_status.status(obj)
    assert reads == ["Grid"] * 2


def test_an_edit_of_one_object_leaves_the_other_known(object_status, reads):
    first = steps.bound_grid(meshes.grid(name="First"))
    second = steps.bound_grid(meshes.grid(name="Second"))
    update()
    object_status.status(first)
    object_status.status(second)
    first.data.update_tag()
    update()
    object_status.status(first)
    object_status.status(second)
    assert reads == ["First", "Second", "First"]


def test_changed_settings_need_no_update(object_status):
    obj = steps.bound_grid(meshes.grid())
    update()
    assert object_status.status(obj).state.name == "BOUND"
    steps.add_group(obj, "Arm", [18, 19, 23])
    obj.meanvalue.roi_group = "Arm"
    assert "region changed" in object_status.status(obj).text
    obj.meanvalue.roi_invert = True
    assert "region changed" in object_status.status(obj).text
    obj.meanvalue.roi_group = ""
    assert object_status.status(obj).state.name == "BOUND"


def test_outside_object_mode_the_last_status_is_shown(object_status, reads):
    obj = steps.bound_grid(meshes.grid())
    update()
    known = object_status.status(obj)
    bpy.ops.object.mode_set(mode='EDIT')
    obj.data.update_tag()
    update()
    assert object_status.status(obj) == known
    bpy.ops.object.mode_set(mode='OBJECT')
    object_status.status(obj)
    assert reads == ["Grid"] * 2


def test_never_seen_in_object_mode(object_status, reads):
    obj = steps.bound_grid(meshes.grid())
    object_status.clear()
    bpy.ops.object.mode_set(mode='EDIT')
    status = object_status.status(obj)
    assert status.state.name == "BOUND"
    assert "not checked in Edit Mode" in status.text
    assert reads == []


def test_a_panel_waits_until_an_object_is_left_alone(object_status, object_model, reads, monkeypatch):
    now = [100.0]
    monkeypatch.setattr(object_model, "clock", lambda: now[0])
    quiet = object_status.QUIET_SECONDS
    obj = steps.bound_grid(meshes.grid())
    update()
    object_status.status(obj)
    for _ in range(5):  # as in a drag: edited and drawn at every step
        obj.data.vertices[3].co.z += 0.1
        obj.data.update()
        update()
        now[0] += 0.5 * quiet
        assert object_status.status(obj, quiet).state.name == "BOUND"
    assert len(reads) == 1
    assert object_model.quiet_in() == pytest.approx(0.5 * quiet)
    now[0] += 0.6 * quiet
    assert object_model.quiet_in() == 0.0
    assert object_status.status(obj, quiet).state.name == "STALE"
    assert len(reads) == 2


def test_a_panel_does_not_wait_for_settings(object_status):
    obj = steps.bound_grid(meshes.grid())
    update()
    object_status.status(obj)
    assert bpy.ops.meanvalue.unbind() == {'FINISHED'}
    obj.data.update_tag()
    update()
    assert object_status.status(obj, object_status.QUIET_SECONDS).state.name == "UNBOUND"


def test_last_known(object_status, reads):
    obj = steps.bound_grid(meshes.grid())
    assert object_status.last_known(obj) is None
    status = object_status.status(obj)
    assert object_status.last_known(obj) is status
    assert len(reads) == 1


def test_an_edit_has_the_panel_drawn_again_by_one_timer(object_status, part, monkeypatch):
    handlers = part("handlers")
    monkeypatch.setattr(handlers, "_is_drawn", lambda: True)
    obj = steps.bound_grid(meshes.grid())
    obj.data.update_tag()
    update()
    assert not bpy.app.timers.is_registered(handlers._draw_again), "nobody has asked for the status yet"
    object_status.status(obj)
    obj.data.update_tag()
    update()
    assert bpy.app.timers.is_registered(handlers._draw_again)
    assert handlers._draw_again() > 0.0
    object_model = part("scene.object_model")
    monkeypatch.setattr(object_model, "clock", lambda: time.monotonic() + object_model.QUIET_SECONDS)
    assert handlers._draw_again() is None
    handlers.unregister()
    assert not bpy.app.timers.is_registered(handlers._draw_again)
    handlers.register(part("registration").ROOMS)


def test_no_timer_without_windows(object_status, part):
    obj = steps.bound_grid(meshes.grid())
    object_status.status(obj)
    obj.data.update_tag()
    update()
    assert not bpy.app.timers.is_registered(part("handlers")._draw_again)


def test_asking_changes_nothing(object_status):
    obj = steps.posed_grid(meshes.textured_grid())
    before = snapshot(obj)
    object_status.status(obj)
    assert_same(before, snapshot(obj))


def test_a_new_file_is_not_mistaken_for_the_old_one(object_status, tmp_path):
    obj = steps.bound_grid(meshes.grid())
    update()
    object_status.status(obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "bound.blend"))
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    obj = meshes.grid()
    assert object_status.status(obj).state.name == "PROBLEM"
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "bound.blend"))
    assert object_status.status(bpy.data.objects["Grid"]).state.name == "BOUND"
