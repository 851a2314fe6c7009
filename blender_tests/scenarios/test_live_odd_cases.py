# SPDX-License-Identifier: GPL-3.0-or-later
"""Live posing of odd objects, odd keys and odd orders of events; what is used of a pose by other operators."""

import bpy
import numpy as np
import pytest
from mathutils import Color
from support import armatures, handles, meshes, steps
from support.handles import BOTTOM, TOP, is_at_rest, move, rest, shown, update


@pytest.fixture
def status(part):
    """status(obj): what the panel says of live posing."""
    return lambda obj: part("live.engine").status(obj) or ("", False)


def follows(obj, offset, vertices=TOP):
    return float(np.abs(shown(obj)[vertices] - rest(obj)[vertices] - np.array(offset, np.float32)).max()) < 1e-3


def test_add_handle_on_a_mesh_with_coordinates_that_are_not_numbers():
    obj = meshes.tube(handles.RINGS, handles.SEGMENTS, "Tube")
    steps.add_group(obj, "Top", TOP)
    obj.data.vertices[TOP[0]].co.x = float("nan")
    with pytest.raises(RuntimeError) as error:
        bpy.ops.meanvalue.add_handle(group="Top")
    assert "Traceback" not in str(error.value), str(error.value)[-300:]
    assert len(obj.meanvalue.handles) == 0


def test_a_control_in_a_huge_objects_space(status):
    obj = meshes.tube(handles.RINGS, handles.SEGMENTS, "Tube")
    steps.add_group(obj, "Top", TOP)
    steps.add_group(obj, "Bottom", BOTTOM)
    obj.scale = (20000.0,) * 3
    update()
    empty = bpy.data.objects.new("Empty", None)
    bpy.context.collection.objects.link(empty)
    meshes.activate(obj)
    assert bpy.ops.meanvalue.add_handle(pin=True, group="Bottom") == {'FINISHED'}
    assert bpy.ops.meanvalue.add_handle(group="Top") == {'FINISHED'}
    obj.meanvalue.handles["Top"].control = empty
    update()
    assert status(obj)[1] is False, status(obj)


def test_a_pinned_shape_key_is_told(status):
    obj, control = handles.tube()
    obj.active_shape_key_index = 0
    obj.show_only_shape_key = True
    update()
    move(control, (1.0, 0.0, 0.0))
    text, _ = status(obj)
    assert "Lock" in text or "pinned" in text, text


@pytest.mark.parametrize("name", ["é" * 31 + "x", "手" * 21, "a" * 63, "x'\"\\[]"])
def test_odd_names(name, status):
    obj = meshes.tube(handles.RINGS, handles.SEGMENTS, "Tube")
    steps.add_group(obj, "Bottom", BOTTOM)
    group = steps.add_group(obj, name, TOP)
    obj.name = name
    assert bpy.ops.meanvalue.add_handle(pin=True, group="Bottom") == {'FINISHED'}
    assert bpy.ops.meanvalue.add_handle(group=group.name) == {'FINISHED'}
    update()
    control = bpy.context.object
    obj.meanvalue.result_key = name
    update()
    move(control, (1.0, 0.0, 0.0))
    assert status(obj)[1] is False, status(obj)
    written = steps.key_positions(obj, name)
    assert np.abs(written[TOP, 0] - rest(obj)[TOP, 0] - 1.0).max() < 1e-3


def test_solve_refuses_what_was_found_for_another_shape(part):
    obj, control = handles.tube(live=False)
    move(control, (1.0, 0.0, 0.0))
    meshes.activate(obj)
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    posing = part("posing.bridge.posing").Posing.to_solve(obj)
    posing.read_triangles(obj)
    part("solver.job").run(posing.work(None))
    if obj.data.shape_keys is None:
        obj.shape_key_add(name="Basis", from_mix=False)
    for point in obj.data.shape_keys.reference_key.data:
        point.co.y += 5.0
    obj.data.update_tag()
    update()
    with pytest.raises(part("errors").SceneError):
        posing.require_unchanged(obj)


def test_select_handle_says_when_the_control_cannot_be_selected():
    obj, control = handles.tube()
    collection = bpy.data.collections.new("Away")
    bpy.context.scene.collection.children.link(collection)
    for each in list(control.users_collection):
        each.objects.unlink(control)
    collection.objects.link(control)
    meshes.activate(obj)
    bpy.context.view_layer.layer_collection.children["Away"].exclude = True
    update()
    try:
        result = bpy.ops.meanvalue.select_handle(index=1)
    except RuntimeError:
        return
    assert bpy.context.object == control, result


def test_leaving_sculpt_mode():
    obj, control = handles.tube()
    meshes.activate(obj)
    bpy.ops.object.mode_set(mode='SCULPT')
    move(control, (1.0, 0.0, 0.0))
    bpy.ops.object.mode_set(mode='OBJECT')
    update()
    move(control, (1.0, 0.0, 0.0))
    assert follows(obj, (2, 0, 0))


def test_apply_on_an_object_scaled_to_nothing_changes_nothing():
    obj, control = handles.tube()
    move(control, (2.0, 0.0, 0.0))
    before = rest(obj)
    obj.scale = (0.0, 0.0, 0.0)
    update()
    meshes.activate(obj)
    try:
        bpy.ops.meanvalue.apply_pose()
    except RuntimeError:
        assert np.array_equal(rest(obj), before)


def test_odd_matrices(status):
    obj, control = handles.tube()
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.collection.objects.link(parent)
    parent.scale = (1.0, 3.0, 0.5)
    parent.rotation_euler = (0.3, 0.2, 0.1)
    obj.parent = parent
    obj.rotation_euler = (0.5, 0.7, 0.2)
    obj.scale = (-1.0, 2.0, 0.5)
    update()
    assert is_at_rest(obj)
    np.array(control.matrix_world)
    control.location.x += 1.0
    control.scale = (-1, 1, 1)
    update()
    assert status(obj)[1] is False
    control.scale = (0, 0, 0)
    update()
    control.scale = (1, 1, 1)
    update()
    assert follows(obj, (1, 0, 0))
    assert status(obj)[1] is False


def test_an_unexpected_error_of_a_job_does_not_hide(part, monkeypatch, status):
    obj, control = handles.tube()
    session = part("solver.session")

    def fail(*_a, **_k):
        raise RuntimeError("out of order")

    monkeypatch.setattr(session, "solve_steps", fail)
    move(control, (1.0, 0.0, 0.0))
    assert status(obj)[1] is True, status(obj)


def test_how_often_the_mesh_is_read_while_it_is_animated_otherwise(part, monkeypatch):
    obj, _control = handles.tube()
    key = obj.shape_key_add(name="Smile", from_mix=False)
    key.value = 0.0
    key.keyframe_insert("value", frame=1)
    key.value = 1.0
    key.keyframe_insert("value", frame=20)
    update()
    scene_input = part("posing.bridge.scene_input")
    gather, seen = scene_input.gather, []
    monkeypatch.setattr(scene_input, "gather", lambda *arguments: seen.append(1) or gather(*arguments))
    for frame in range(1, 21):
        bpy.context.scene.frame_set(frame)
    assert len(seen) <= 2, len(seen)


def test_duplicate_removed_original_gives_up_control(status):
    obj, control = handles.tube()
    meshes.activate(obj)
    bpy.ops.object.duplicate()
    twin = bpy.context.object
    update()
    control.parent = None
    bpy.data.objects.remove(obj)
    update()
    control.location.x += 1.0
    update()
    assert status(twin)[1] is False, status(twin)


def test_choosing_a_control_for_an_object_scaled_to_nothing(capfd):
    obj, _control = handles.tube(live=False)
    obj.scale = (0, 0, 0)
    update()
    other = bpy.data.objects.new("Other", None)
    bpy.context.collection.objects.link(other)
    obj.meanvalue.handles["Top"].control = other
    err = capfd.readouterr()
    assert "Traceback" not in err.out + err.err, (err.out + err.err)[-400:]


def test_result_edited_by_hand_or_by_a_script_is_put_right():
    obj, control = handles.tube()
    move(control, (1.0, 0.0, 0.0))
    posed = shown(obj)
    key = obj.data.shape_keys.key_blocks["Mean-Value"]
    for point in key.data:
        point.co.z += 3.0
    obj.data.update_tag()
    update()
    assert np.abs(shown(obj) - posed).max() < 1e-2


def test_live_turned_on_in_edit_mode(status):
    obj, control = handles.tube(live=False)
    meshes.activate(obj)
    bpy.ops.object.mode_set(mode='EDIT')
    obj.meanvalue.live = True
    update()
    bpy.ops.object.mode_set(mode='OBJECT')
    update()
    move(control, (1.0, 0.0, 0.0))
    assert status(obj)[1] is False, status(obj)


def test_a_muted_result_is_told(status):
    obj, control = handles.tube()
    obj.data.shape_keys.key_blocks["Mean-Value"].value = 0.0
    update()
    move(control, (1.0, 0.0, 0.0))
    assert "Mean-Value" in status(obj)[0], status(obj)


def test_a_mesh_emptied_while_live(status):
    obj, control = handles.tube()
    move(control, (1.0, 0.0, 0.0))
    obj.data.clear_geometry()
    update()
    move(control, (1.0, 0.0, 0.0))
    assert status(obj)[1] is True


def test_another_mesh_of_as_many_vertices(status):
    obj, control = handles.tube()
    other, _ = handles.tube("Other")
    move(control, (1.0, 0.0, 0.0))
    mesh = other.data.copy()
    for point in mesh.shape_keys.reference_key.data:
        point.co.y *= 2
    obj.data = mesh
    update()
    move(control, (1.0, 0.0, 0.0))
    assert status(obj)[1] is True or follows(obj, (2, 0, 0))


def test_removing_a_line_of_a_duplicate_leaves_the_originals_control_alone(status):
    obj, control = handles.tube()
    name = control.name
    meshes.activate(obj)
    bpy.ops.object.duplicate()
    twin = bpy.context.object
    update()
    twin.meanvalue.active_handle = 1
    assert bpy.ops.meanvalue.remove_handle() == {'FINISHED'}
    update()
    assert name in bpy.data.objects, "the original's control was deleted"


def test_a_result_that_is_not_numbers_is_put_right(status):
    obj, control = handles.tube()
    move(control, (1.0, 0.0, 0.0))
    obj.meanvalue.live = False
    update()
    obj.data.shape_keys.key_blocks["Mean-Value"].data[60].co.x = float("nan")
    obj.meanvalue.live = True
    update()
    obj.update_tag()
    update()
    assert status(obj)[1] is False, status(obj)


def test_reset_of_bones_that_are_parent_and_child():
    obj, _control = handles.tube(live=True)
    steps.add_group(obj, "Middle", range(64, 72))
    rig = armatures.make(Parent=((0, 0, 0), (0, 0, 4)), Child=((0, 0, 4), (0, 0, 9), "Parent"))
    meshes.activate(obj)
    obj.vertex_groups.active_index = obj.vertex_groups["Middle"].index
    assert bpy.ops.meanvalue.add_handle(group="Middle") == {'FINISHED'}
    for name, bone in (("Top", "Child"), ("Middle", "Parent")):
        line = obj.meanvalue.handles[name]
        line.control = rig
        line.bone = bone
    obj.meanvalue.handles.move(1, 2)
    obj.update_tag()
    update()
    rig.pose.bones["Parent"].rotation_mode = 'XYZ'
    rig.pose.bones["Parent"].rotation_euler.x = 0.5
    rig.pose.bones["Child"].rotation_mode = 'XYZ'
    rig.pose.bones["Child"].rotation_euler.x = 0.5
    update()
    assert not is_at_rest(obj)
    handles.assert_reset_puts_at_rest(obj)


def test_reset_of_a_control_and_its_child_in_the_other_order():
    obj, control = handles.tube()
    steps.add_group(obj, "Middle", range(64, 72))
    meshes.activate(obj)
    assert bpy.ops.meanvalue.add_handle(group="Middle") == {'FINISHED'}
    update()
    child = obj.meanvalue.handles["Middle"].control
    child.parent = control
    update()
    child.matrix_parent_inverse = control.matrix_world.inverted()
    update()
    obj.meanvalue.live = False
    for line in obj.meanvalue.handles:
        if line.control:
            line.control = line.control
    obj.meanvalue.live = True
    update()
    assert is_at_rest(obj, 1e-3)
    control.rotation_mode = 'XYZ'
    control.rotation_euler = (0.5, 0.2, 0.1)
    move(control, (1.0, 0.5, 0.0))
    assert not is_at_rest(obj)
    handles.assert_reset_puts_at_rest(obj)


def test_a_line_its_points_and_its_control_are_shown_in_the_same_colour():
    """Points are drawn in the line's colour as it is; an object's is linear, and made brighter when it is shown."""
    obj, control = handles.tube()
    line = obj.meanvalue.handles["Top"]
    assert line.bl_rna.properties["color"].subtype == 'COLOR_GAMMA'
    made, chosen = tuple(line.color), (0.1, 0.2, 0.3)
    assert np.abs(shown_color(control) - made).max() < 1e-4
    line.color = chosen
    assert np.abs(shown_color(control) - chosen).max() < 1e-4


def shown_color(obj):
    return np.array(Color(obj.color[:3]).from_scene_linear_to_srgb())


def test_the_control_is_shown_in_the_mirrored_object():
    obj, _control = handles.tube()
    obj.scale = (-1, 1, 1)
    update()
    assert bpy.ops.meanvalue.reset_handles() == {'FINISHED'}
    update()
    assert is_at_rest(obj, 1e-4), np.abs(shown(obj) - rest(obj)).max()


def test_two_live_objects_in_two_scenes(status):
    obj, control = handles.tube("First")
    scene = bpy.data.scenes.new("Second")
    bpy.context.window.scene = scene
    other, other_control = handles.tube("Second")
    move(other_control, (1.0, 0.0, 0.0))
    assert abs((shown(other) - rest(other))[TOP[0], 0] - 1.0) < 1e-3
    control.location.x += 1.0
    bpy.context.window.scene = bpy.data.scenes[0]
    update()
    assert abs((shown(obj) - rest(obj))[TOP[0], 0] - 1.0) < 1e-3


def test_the_object_is_in_an_excluded_collection(status):
    obj, control = handles.tube()
    collection = bpy.data.collections.new("Away")
    bpy.context.scene.collection.children.link(collection)
    for each in (obj, control):
        for home in list(each.users_collection):
            home.objects.unlink(each)
        collection.objects.link(each)
    update()
    layer = bpy.context.view_layer.layer_collection.children["Away"]
    layer.exclude = True
    update()
    control.location.x += 1.0
    update()
    layer.exclude = False
    update()
    assert abs((shown(obj) - rest(obj))[TOP[0], 0] - 1.0) < 1e-3
    assert status(obj)[1] is False
