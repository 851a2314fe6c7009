# SPDX-License-Identifier: GPL-3.0-or-later
"""Library overrides: what is said of them, and that it helps."""

import bpy
import pytest
from support import installed, meshes, steps
from support.rigs import update


@pytest.fixture
def override(tmp_path):
    """An override of an object of another file, whose mesh is linked."""
    meshes.tube(name="Character")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    installed.enable()
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, wanted):
        wanted.objects = ["Character"]
    bpy.context.collection.objects.link(wanted.objects[0])
    obj = wanted.objects[0].override_create(remap_local_usages=True)
    update()
    meshes.activate(obj)
    return obj


def test_an_override_is_told_what_helps(override, part):
    problem = part("scene.subject").object_problem(override)
    assert "override" in problem and "Pose it in the file that it comes from" in problem and "library.blend" in problem
    assert "no longer arrive" in problem  # what Make Local costs
    assert not bpy.ops.meanvalue.add_handle.poll()


def test_made_local_with_its_mesh_it_can_be_posed(override, part):
    assert bpy.ops.object.make_local(type='SELECT_OBDATA') == {'FINISHED'}
    obj = bpy.context.object
    assert part("scene.subject").object_problem(obj) is None
    steps.add_handle(obj, "Top", range(64, 72))


def test_an_overridden_mesh_is_refused_since_its_keys_would_be_lost(override, part):
    override.data.override_create(remap_local_usages=True)
    assert "are not saved" in part("scene.subject").object_problem(override)
