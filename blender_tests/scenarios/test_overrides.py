# SPDX-License-Identifier: GPL-3.0-or-later
"""Library overrides: what is said of them, and that it helps."""

import bpy
import pytest
from support import baking, handles, installed, meshes, steps
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


def link_action(folder, id_block):
    """Gives a datablock its own action again, linked from another file. Returns that."""
    action, path = id_block.animation_data.action, str(folder / "actions.blend")
    bpy.data.libraries.write(path, {action}, fake_user=True)
    with bpy.data.libraries.load(path, link=True) as (_, wanted):
        wanted.actions = [action.name]
    id_block.animation_data.action = wanted.actions[0]
    return wanted.actions[0]


def key_counts(id_block):
    return {len(curve.keyframe_points) for curve in baking.curves(id_block)}


@pytest.mark.parametrize("ways", ["handles", "bake"])
def test_keyframes_go_into_a_copy_of_a_linked_action(tmp_path, ways):
    """Into the linked one they would be gone when the file is opened again."""
    obj, control = baking.animated_tube()
    animated = control if ways == "handles" else obj.shape_key_add(name="Smile").id_data
    if ways == "bake":
        animated.key_blocks["Smile"].keyframe_insert("value", frame=1)
    linked, before = link_action(tmp_path, animated), key_counts(animated)
    if ways == "handles":
        bpy.context.scene.frame_set(40)
        assert bpy.ops.meanvalue.keyframe_handles() == {'FINISHED'}
    else:
        baking.bake(target='SHAPE_KEYS')
    assert animated.animation_data.action.library is None and key_counts(animated) != before
    animated.animation_data.action = linked
    assert key_counts(animated) == before


def test_a_linked_control_takes_no_keyframes(tmp_path, capfd):
    obj, _control = handles.tube()
    bpy.data.libraries.write(str(tmp_path / "props.blend"), {meshes.new_object("Prop")})
    with bpy.data.libraries.load(str(tmp_path / "props.blend"), link=True) as (_, wanted):
        wanted.objects = ["Prop"]
    bpy.context.collection.objects.link(wanted.objects[0])
    obj.meanvalue.handles["Top"].control = wanted.objects[0]
    meshes.activate(obj)
    bpy.ops.meanvalue.keyframe_handles()
    assert wanted.objects[0].animation_data is None and "would not be saved" in capfd.readouterr().out
