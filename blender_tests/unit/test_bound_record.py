# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel says of an object, after edits as after settings."""

import bpy
import pytest
from support import meshes, steps
from support.handles import update


@pytest.fixture
def problem(part):
    return part("posing.bridge.posing").problem


def test_what_is_done_to_handles_and_mesh_is_shown(problem, part):
    obj = meshes.grid()
    assert problem(obj)[1] is False
    steps.list_anchors(obj, A=[0, 4, 20], B=[24])
    update()
    assert problem(obj) is None
    bpy.ops.meanvalue.bind()
    obj.vertex_groups["A"].add([2], 1.0, 'REPLACE')
    update()
    assert problem(obj) is None, "the next pose takes it in"
    count = part("posing.bridge.scene_input").member_count
    assert (count(obj, 0), count(obj, 1)) == (4, 1)
    obj.data.vertices[3].co.z += 1.0
    obj.data.update()
    update()
    assert problem(obj)[1] is True
    obj.vertex_groups.remove(obj.vertex_groups["B"])
    assert problem(obj)[1] is False and "'B'" in problem(obj)[0]


def test_in_edit_mode(problem):
    obj = steps.bound_grid(meshes.grid())
    update()
    assert problem(obj) is None
    bpy.ops.object.mode_set(mode='EDIT')
    obj.data.update_tag()
    update()
    assert steps.is_bound(obj)


def test_a_new_file_is_not_mistaken_for_the_old_one(problem, tmp_path):
    obj = steps.bound_grid(meshes.grid())
    update()
    problem(obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "bound.blend"))
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    obj = meshes.grid()
    assert problem(obj) is not None
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "bound.blend"))
    assert steps.is_bound(bpy.data.objects["Grid"])
