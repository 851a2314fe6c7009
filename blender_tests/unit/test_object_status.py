# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel says of an object, after edits as after settings."""

import bpy
import pytest
from support import meshes, steps
from support.snapshot import assert_same, snapshot


@pytest.fixture
def object_status(part):
    return part("posing.bridge.object_status")


def update():
    bpy.context.view_layer.update()


def test_what_is_done_to_handles_and_mesh_is_shown(object_status):
    obj = meshes.grid()
    state = lambda: object_status.status(obj).state.name  # noqa: E731
    assert state() == "PROBLEM"
    steps.list_anchors(obj, A=[0, 4, 20], B=[24])
    update()
    assert state() == "UNBOUND"
    bpy.ops.meanvalue.bind()
    assert state() == "BOUND"
    obj.vertex_groups["A"].add([2], 1.0, 'REPLACE')
    update()
    assert state() == "BOUND"  # the next pose takes it in
    assert (object_status.member_count(obj, "A"), object_status.member_count(obj, "B")) == (4, 1)
    obj.data.vertices[3].co.z += 1.0
    obj.data.update()
    update()
    assert state() == "STALE"
    obj.vertex_groups.remove(obj.vertex_groups["B"])
    assert state() == "PROBLEM" and "'B'" in object_status.status(obj).text


@pytest.mark.parametrize("setting, value", [("roi_group", "Arm"), ("method", "full"), ("merge_distance", 0.001)])
def test_changed_settings_need_no_update(object_status, setting, value):
    obj = steps.bound_grid(meshes.grid())
    steps.add_group(obj, "Arm", [18, 19, 23])
    update()
    setattr(obj.meanvalue, setting, value)
    assert object_status.status(obj).state.name == "BOUND"


@pytest.mark.parametrize("is_known", [True, False])
def test_in_edit_mode(object_status, is_known):
    obj = steps.bound_grid(meshes.grid())
    update()
    if is_known:
        object_status.status(obj)
    bpy.ops.object.mode_set(mode='EDIT')
    obj.data.update_tag()
    update()
    assert object_status.status(obj).state.name == "BOUND"


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
