# SPDX-License-Identifier: GPL-3.0-or-later
"""Library overrides: what is said of them, and that it helps."""

import bpy
import pytest
from support import baking, handles, installed, libraries, meshes, steps
from support.rigs import update


@pytest.fixture
def override(tmp_path):
    """An override of an object of another file, whose mesh is linked."""
    meshes.tube(name="Character")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    installed.enable()
    (found,) = libraries.load(tmp_path / "library.blend", "objects", ["Character"], link=True)
    obj = found.override_create(remap_local_usages=True)
    update()
    meshes.activate(obj)
    return obj


def test_an_override_is_told_what_helps(override, part):
    problem = part("scene.subject").object_problem(override)
    assert "override" in problem and "library.blend" in problem
    assert not bpy.ops.meanvalue.add_handle.poll()


def test_made_local_with_its_mesh_it_can_be_posed(override, part):
    assert bpy.ops.object.make_local(type='SELECT_OBDATA') == {'FINISHED'}
    obj = bpy.context.object
    assert part("scene.subject").object_problem(obj) is None
    steps.add_handle(obj, "Top", range(64, 72))


def test_an_overridden_mesh_is_refused_since_its_keys_would_be_lost(override, part):
    override.data.override_create(remap_local_usages=True)
    assert "are not saved" in part("scene.subject").object_problem(override)


@pytest.mark.parametrize("way", ["handles", "bake"])
def test_keyframes_go_into_a_copy_of_a_linked_action(tmp_path, way):
    """Into the linked one they would be gone when the file is opened again."""
    obj, control = baking.animated_tube()
    animated = control if way == "handles" else obj.shape_key_add(name="Smile").id_data
    if way == "bake":
        animated.key_blocks["Smile"].keyframe_insert("value", frame=1)
    animation = animated.animation_data
    action = animation.action = libraries.linked(tmp_path, animation.action, "actions")
    before = [len(curve.keyframe_points) for curve in baking.curves(animated)]
    bpy.context.scene.frame_set(40)
    if way == "handles":
        assert bpy.ops.meanvalue.keyframe_handles() == {'FINISHED'}
    else:
        baking.bake(target='SHAPE_KEYS')
    assert animation.action.library is None
    assert [len(curve.keyframe_points) for curve in baking.curves(animated)] != before
    animation.action = action
    assert [len(curve.keyframe_points) for curve in baking.curves(animated)] == before


def test_a_linked_control_takes_no_keyframes(tmp_path, capfd):
    obj, _control = handles.tube()
    prop = libraries.linked(tmp_path, meshes.new_object("Prop"), "objects")
    obj.meanvalue.handles["Top"].control = prop
    meshes.activate(obj)
    bpy.ops.meanvalue.keyframe_handles()
    assert prop.animation_data is None and "would not be saved" in capfd.readouterr().out
