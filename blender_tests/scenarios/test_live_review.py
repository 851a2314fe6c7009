# SPDX-License-Identifier: GPL-3.0-or-later
"""Live posing where a review found it to stop following, or to write what belongs to another state."""

import bpy
import numpy as np
import pytest
from support import handles, meshes, steps
from support.handles import BOTTOM, TOP, is_at_rest, move, rest, shown, update


@pytest.fixture
def status(part):
    """status(obj): what the panel says of live posing."""
    return lambda obj: part("live.engine").status(obj)


def follows(obj, offset, vertices=TOP):
    return float(np.abs(shown(obj)[vertices] - rest(obj)[vertices] - np.array(offset, np.float32)).max()) < 1e-3


@pytest.mark.parametrize("value", [float("nan"), 1e30])
def test_it_goes_on_when_a_control_comes_back_from_where_nothing_can_be_solved(status, value):
    obj, control = handles.tube()
    place = control.location.copy()
    control.location.x = value
    update()
    control.location = place
    move(control, (1.0, 0.0, 0.0))
    assert status(obj)[1] is False, status(obj)
    assert follows(obj, (1, 0, 0))


def test_it_goes_on_when_the_object_has_a_size_again(status):
    obj, control = handles.tube()
    obj.scale = (0.0, 0.0, 0.0)
    update()
    obj.scale = (1.0, 1.0, 1.0)
    update()
    move(control, (1.0, 0.0, 0.0))
    assert status(obj)[1] is False, status(obj)
    assert follows(obj, (1, 0, 0))


def test_it_goes_on_when_the_control_is_in_the_scene_again(status):
    obj, control = handles.tube()
    collection = control.users_collection[0]
    collection.objects.unlink(control)
    update()
    obj.update_tag()
    update()
    collection.objects.link(control)
    update()
    move(control, (1.0, 0.0, 0.0))
    assert status(obj)[1] is False, status(obj)
    assert follows(obj, (1, 0, 0))


def test_it_goes_on_when_the_other_object_with_the_mesh_is_no_longer_live(status):
    obj, control = handles.tube()
    twin = obj.copy()
    bpy.context.collection.objects.link(twin)
    line = twin.meanvalue.anchor_groups["Top"]
    other = bpy.data.objects.new("Other", None)
    bpy.context.collection.objects.link(other)
    other.location = control.matrix_world.translation
    line.control = other
    update()
    waiting = next(each for each in (obj, twin) if status(each)[1])
    first = obj if waiting == twin else twin
    first.meanvalue.live = False
    update()
    move(waiting.meanvalue.anchor_groups["Top"].control, (1.0, 0.0, 0.0))
    assert status(waiting)[1] is False, status(waiting)
    assert follows(waiting, (1, 0, 0))


def test_it_goes_on_when_the_bone_is_there_again(status):
    obj, _control = handles.tube()
    armature = bpy.data.armatures.new("Rig")
    rig = bpy.data.objects.new("Rig", armature)
    bpy.context.collection.objects.link(rig)
    meshes.activate(rig)
    bpy.ops.object.mode_set(mode='EDIT')
    bone = armature.edit_bones.new("Bone")
    bone.tail = (0, 0, 1)
    bpy.ops.object.mode_set(mode='OBJECT')
    line = obj.meanvalue.anchor_groups["Top"]
    line.control = rig
    line.bone = "Bone"
    update()
    assert status(obj)[1] is False
    armature.bones["Bone"].name = "Renamed"
    update()
    obj.update_tag()
    update()
    armature.bones["Renamed"].name = "Bone"
    update()
    rig.pose.bones["Bone"].location = (1.0, 0.0, 0.0)
    update()
    assert status(obj)[1] is False, status(obj)


def three_lines(live=True):
    obj = meshes.tube(handles.RINGS, handles.SEGMENTS, "Tube")
    middle = range(8 * handles.SEGMENTS, 9 * handles.SEGMENTS)
    for name, members in (("Bottom", BOTTOM), ("Middle", middle), ("Top", TOP)):
        steps.add_group(obj, name, members)
    assert bpy.ops.meanvalue.add_pin(group="Bottom") == {'FINISHED'}
    assert bpy.ops.meanvalue.add_pin(group="Middle") == {'FINISHED'}
    assert bpy.ops.meanvalue.add_handle(group="Top", live=live) == {'FINISHED'}
    update()
    return obj, bpy.context.object, middle


def test_a_pin_of_the_artists_own_group_is_removed():
    obj, control, middle = three_lines()
    move(control, (1.0, 0.0, 0.0))
    obj.meanvalue.active_anchor_group = 0
    assert bpy.ops.meanvalue.remove_anchor_group() == {'FINISHED'}
    update()
    move(control, (1.0, 0.0, 0.0))
    assert follows(obj, (0, 0, 0), middle), shown(obj)[middle][:2] - rest(obj)[middle][:2]
    assert follows(obj, (2, 0, 0), TOP)


def test_lines_reordered_by_a_script():
    obj, control, middle = three_lines()
    obj.meanvalue.anchor_groups.move(2, 0)
    move(control, (1.0, 0.0, 0.0))
    assert follows(obj, (0, 0, 0), BOTTOM), "the pin was moved by the handle's control"
    assert follows(obj, (1, 0, 0), TOP)


def test_an_animated_line_is_turned_off():
    obj, control, middle = three_lines()
    path = "meanvalue.anchor_groups[0].is_enabled"
    obj.keyframe_insert(path, frame=1)
    obj.meanvalue.anchor_groups[0].is_enabled = False
    obj.keyframe_insert(path, frame=10)
    bpy.context.scene.frame_set(1)
    move(control, (1.0, 0.0, 0.0))
    bpy.context.scene.frame_set(10)
    update()
    move(control, (1.0, 0.0, 0.0))
    assert follows(obj, (0, 0, 0), middle)
    assert follows(obj, (2, 0, 0), TOP)


def test_names_swapped_between_two_live_objects():
    first, first_control = handles.tube("First")
    second, second_control = handles.tube("Second")
    basis = second.data.shape_keys.reference_key
    for point in basis.data:
        point.co.x *= 3.0
    second.data.update_tag()
    update()
    second.meanvalue.live = False
    update()
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    second.meanvalue.live = True
    update()
    first.name = "Swap"
    second.name = "First"
    first.name = "Second"
    update()
    move(first_control, (1.0, 0.0, 0.0))
    move(second_control, (0.0, 1.0, 0.0))
    assert follows(first, (1, 0, 0)) and follows(first, (0, 0, 0), BOTTOM)
    assert follows(second, (0, 1, 0)) and follows(second, (0, 0, 0), BOTTOM)


def test_renamed_it_follows_without_being_edited():
    obj, control = handles.tube()
    obj.name = "Another"
    update()
    move(control, (2.0, 0.0, 0.0))
    assert follows(obj, (2, 0, 0))


def test_another_result_key_shows_the_pose():
    obj, control = handles.tube()
    move(control, (2.0, 0.0, 0.0))
    obj.meanvalue.result_key = "Other"
    update()
    written = steps.key_positions(obj, "Other")
    assert np.abs(written[TOP, 0] - rest(obj)[TOP, 0] - 2.0).max() < 1e-3


def test_a_second_result_name_for_a_shared_mesh_as_the_message_advises(status):
    obj, control = handles.tube()
    twin = obj.copy()
    bpy.context.collection.objects.link(twin)
    update()
    move(control, (2.0, 0.0, 0.0))
    twin.meanvalue.result_key = "Twin"
    update()
    keys = obj.data.shape_keys.key_blocks
    assert not keys["Mean-Value"].mute, "the first object's result was muted"


def test_edited_through_another_object_with_the_mesh():
    obj, control = handles.tube()
    other = bpy.data.objects.new("Other", obj.data)
    bpy.context.collection.objects.link(other)
    update()
    move(control, (1.0, 0.0, 0.0))
    meshes.activate(other)
    bpy.ops.object.mode_set(mode='EDIT')
    update()
    move(control, (1.0, 0.0, 0.0))
    bpy.ops.object.mode_set(mode='OBJECT')
    update()
    assert follows(obj, (2, 0, 0)), shown(obj)[TOP][0] - rest(obj)[TOP][0]


def test_a_control_that_follows_the_mesh_itself(status):
    obj, control = handles.tube()
    own = bpy.data.objects.new("Own", None)
    bpy.context.collection.objects.link(own)
    own.parent = obj
    own.parent_type = 'VERTEX'
    own.parent_vertices[0] = TOP[0]
    update()
    obj.meanvalue.anchor_groups["Top"].control = own
    update()
    places = []
    own.location.x += 0.1
    for _ in range(12):
        obj.update_tag()
        update()
        places.append(round(float(shown(obj)[TOP[0], 0] - rest(obj)[TOP[0], 0]), 3))
    assert abs(places[-1] - places[2]) < 0.2, places


def test_reset_of_a_control_that_is_a_child_of_another():
    obj, control, middle = three_lines()
    line = obj.meanvalue.anchor_groups["Middle"]
    obj.meanvalue.active_anchor_group = 1
    meshes.activate(obj)
    assert bpy.ops.meanvalue.remove_anchor_group() == {'FINISHED'}
    obj.vertex_groups.active_index = obj.vertex_groups["Middle"].index
    assert bpy.ops.meanvalue.add_handle(group="Middle") == {'FINISHED'}
    update()
    child = obj.meanvalue.anchor_groups["Middle"].control
    child.parent = control
    child.matrix_parent_inverse = control.matrix_world.inverted()
    update()
    move(control, (1.0, 0.0, 0.0))
    meshes.activate(obj)
    assert bpy.ops.meanvalue.reset_handles() == {'FINISHED'}
    update()
    assert is_at_rest(obj, 1e-3), np.abs(shown(obj) - rest(obj)).max()


def test_applying_carries_along_keys_that_are_relative_to_others():
    obj, control = handles.tube()
    first = obj.shape_key_add(name="First", from_mix=False)
    second = obj.shape_key_add(name="Second", from_mix=False)
    second.relative_key = first
    update()
    move(control, (2.0, 0.0, 0.0))
    before = steps.key_positions(obj, "Second") - steps.key_positions(obj, "First")
    meshes.activate(obj)
    assert bpy.ops.meanvalue.apply_pose() == {'FINISHED'}
    after = steps.key_positions(obj, "Second") - steps.key_positions(obj, "First")
    assert np.abs(after - before).max() < 1e-4, np.abs(after - before).max()


def test_no_solve_of_places_that_no_control_has(part, monkeypatch):
    obj, control = handles.tube()
    move(control, (1.0, 0.0, 0.0))
    other = bpy.data.objects.new("Other", None)
    other.location = (50.0, 0.0, 0.0)
    bpy.context.collection.objects.link(other)
    update()
    session = part("session")
    solve, seen = session.solve, []

    def spy(binding, bind_input, targets, *rest, **options):
        seen.append(float(np.abs(targets - bind_input.rest[bind_input.anchors]).max()))
        return solve(binding, bind_input, targets, *rest, **options)

    monkeypatch.setattr(session, "solve", spy)
    obj.meanvalue.anchor_groups["Top"].control = other
    update()
    assert all(distance < 2.0 for distance in seen), seen


def test_no_solve_of_places_that_no_control_has_while_a_handle_is_made(part, monkeypatch):
    obj, control, middle = three_lines()
    obj.meanvalue.active_anchor_group = 1
    meshes.activate(obj)
    assert bpy.ops.meanvalue.remove_anchor_group() == {'FINISHED'}
    update()
    move(control, (1.0, 0.0, 0.0))
    session = part("session")
    solve, seen = session.solve, []

    def spy(binding, bind_input, targets, *rest, **options):
        seen.append(float(np.abs(targets - bind_input.rest[bind_input.anchors]).max()))
        return solve(binding, bind_input, targets, *rest, **options)

    monkeypatch.setattr(session, "solve", spy)
    meshes.activate(obj)
    assert bpy.ops.meanvalue.add_handle(group="Middle") == {'FINISHED'}
    update()
    assert all(distance < 1.5 for distance in seen), seen


def test_a_failed_render_does_not_stop_it_for_ever():
    obj, control = handles.tube()
    scene = bpy.context.scene
    scene.camera = None
    for camera in [each for each in bpy.data.objects if each.type == 'CAMERA']:
        bpy.data.objects.remove(camera)
    with pytest.raises(RuntimeError):
        bpy.ops.render.render(animation=True)
    move(control, (1.0, 0.0, 0.0))
    assert follows(obj, (1, 0, 0))


def test_a_movie_that_cannot_be_written_does_not_stop_it_for_ever(part, tmp_path):
    obj, control = handles.tube()
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.frame_end = 1
    scene.render.engine = 'BLENDER_WORKBENCH'
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.render.image_settings.file_format = 'FFMPEG'
    scene.render.ffmpeg.format = 'MPEG4'
    scene.render.ffmpeg.codec = 'H264'
    scene.render.filepath = "/proc/nowhere/x.mp4"
    try:
        bpy.ops.render.render(animation=True)
    except RuntimeError:
        pass
    move(control, (1.0, 0.0, 0.0))
    assert follows(obj, (1, 0, 0)), part("live.engine")._is_rendering


def test_a_file_that_cannot_be_read_does_not_stop_it(tmp_path):
    obj, control = handles.tube()
    broken = tmp_path / "broken.blend"
    broken.write_bytes(b"BLENDER-v304" + bytes(100))
    with pytest.raises(RuntimeError):
        bpy.ops.wm.open_mainfile(filepath=str(broken))
    obj = bpy.data.objects["Tube"]
    control = obj.meanvalue.anchor_groups["Top"].control
    move(control, (1.0, 0.0, 0.0))
    assert follows(obj, (1, 0, 0))


def test_add_handle_on_a_mesh_with_coordinates_that_are_not_numbers():
    obj = meshes.tube(handles.RINGS, handles.SEGMENTS, "Tube")
    steps.add_group(obj, "Top", TOP)
    obj.data.vertices[TOP[0]].co.x = float("nan")
    with pytest.raises(RuntimeError) as error:
        bpy.ops.meanvalue.add_handle(group="Top")
    assert "Traceback" not in str(error.value), str(error.value)[-300:]
    assert len(obj.meanvalue.anchor_groups) == 0


def test_a_control_in_a_huge_objects_space(status):
    obj = meshes.tube(handles.RINGS, handles.SEGMENTS, "Tube")
    steps.add_group(obj, "Top", TOP)
    steps.add_group(obj, "Bottom", BOTTOM)
    obj.scale = (20000.0,) * 3
    update()
    empty = bpy.data.objects.new("Empty", None)
    bpy.context.collection.objects.link(empty)
    meshes.activate(obj)
    assert bpy.ops.meanvalue.add_pin(group="Bottom") == {'FINISHED'}
    assert bpy.ops.meanvalue.add_handle(group="Top") == {'FINISHED'}
    obj.meanvalue.anchor_groups["Top"].control = empty
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
    assert bpy.ops.meanvalue.add_pin(group="Bottom") == {'FINISHED'}
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
    solve = part("operators.solve").MEANVALUE_OT_solve
    posing = part("workers.posing").Posing.to_solve(obj)
    outcome = posing.work(None)
    if obj.data.shape_keys is None:
        obj.shape_key_add(name="Basis", from_mix=False)
    for point in obj.data.shape_keys.reference_key.data:
        point.co.y += 5.0
    obj.data.update_tag()
    update()
    with pytest.raises(part("errors").SceneError):
        solve.finish(None, obj, posing, outcome)


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


@pytest.mark.parametrize("live", [True, False])
def test_applying_a_pose_of_a_shape_key_does_not_pose_it_twice(live):
    obj = meshes.tube(handles.RINGS, handles.SEGMENTS, "Tube")
    steps.list_anchors(obj, Bottom=BOTTOM, Top=TOP)
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    assert bpy.ops.meanvalue.add_pose_key() == {'FINISHED'}
    steps.move(obj, TOP, (2.0, 0.0, 0.0))
    obj.meanvalue.live = live
    update()
    if not live:
        steps.solve()
    posed = shown(obj)
    assert np.abs(posed - rest(obj)).max() > 1.0
    assert bpy.ops.meanvalue.apply_pose() == {'FINISHED'}
    update()
    if not live:
        assert bpy.ops.meanvalue.bind() == {'FINISHED'}
        steps.solve()
    assert np.abs(shown(obj) - posed).max() < 1e-3, np.abs(shown(obj) - posed).max()


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
    start = np.array(control.matrix_world)
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
    session = part("session")
    solve = session.solve

    def fail(*_a, **_k):
        raise RuntimeError("out of order")

    monkeypatch.setattr(session, "solve", fail)
    move(control, (1.0, 0.0, 0.0))
    assert status(obj)[1] is True, status(obj)


def test_how_often_the_mesh_is_read_while_it_is_animated_otherwise(part, monkeypatch):
    obj, control = handles.tube()
    key = obj.shape_key_add(name="Smile", from_mix=False)
    key.value = 0.0
    key.keyframe_insert("value", frame=1)
    key.value = 1.0
    key.keyframe_insert("value", frame=20)
    update()
    scene_input = part("bridge.scene_input")
    gather, seen = scene_input.gather, []
    monkeypatch.setattr(scene_input, "gather", lambda o: seen.append(1) or gather(o))
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
    obj, control = handles.tube(live=False)
    obj.scale = (0, 0, 0)
    update()
    other = bpy.data.objects.new("Other", None)
    bpy.context.collection.objects.link(other)
    obj.meanvalue.anchor_groups["Top"].control = other
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
    twin.meanvalue.active_anchor_group = 1
    assert bpy.ops.meanvalue.remove_anchor_group() == {'FINISHED'}
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
    armature = bpy.data.armatures.new("Rig")
    rig = bpy.data.objects.new("Rig", armature)
    bpy.context.collection.objects.link(rig)
    meshes.activate(rig)
    bpy.ops.object.mode_set(mode='EDIT')
    parent = armature.edit_bones.new("Parent")
    parent.head, parent.tail = (0, 0, 0), (0, 0, 4)
    child = armature.edit_bones.new("Child")
    child.head, child.tail = (0, 0, 4), (0, 0, 9)
    child.parent = parent
    bpy.ops.object.mode_set(mode='OBJECT')
    meshes.activate(obj)
    obj.vertex_groups.active_index = obj.vertex_groups["Middle"].index
    assert bpy.ops.meanvalue.add_handle(group="Middle") == {'FINISHED'}
    for name, bone in (("Top", "Child"), ("Middle", "Parent")):
        line = obj.meanvalue.anchor_groups[name]
        line.control = rig
        line.bone = bone
    obj.meanvalue.anchor_groups.move(1, 2)
    obj.update_tag()
    update()
    rig.pose.bones["Parent"].rotation_mode = 'XYZ'
    rig.pose.bones["Parent"].rotation_euler.x = 0.5
    rig.pose.bones["Child"].rotation_mode = 'XYZ'
    rig.pose.bones["Child"].rotation_euler.x = 0.5
    update()
    assert not is_at_rest(obj)
    meshes.activate(obj)
    assert bpy.ops.meanvalue.reset_handles() == {'FINISHED'}
    update()
    assert is_at_rest(obj, 1e-3), np.abs(shown(obj) - rest(obj)).max()


def test_reset_of_a_control_and_its_child_in_the_other_order():
    obj, control = handles.tube()
    steps.add_group(obj, "Middle", range(64, 72))
    meshes.activate(obj)
    assert bpy.ops.meanvalue.add_handle(group="Middle") == {'FINISHED'}
    update()
    child = obj.meanvalue.anchor_groups["Middle"].control
    child.parent = control
    update()
    child.matrix_parent_inverse = control.matrix_world.inverted()
    update()
    obj.meanvalue.live = False
    for line in obj.meanvalue.anchor_groups:
        if line.control:
            line.control = line.control
    obj.meanvalue.live = True
    update()
    assert is_at_rest(obj, 1e-3)
    control.rotation_mode = 'XYZ'
    control.rotation_euler = (0.5, 0.2, 0.1)
    move(control, (1.0, 0.5, 0.0))
    assert not is_at_rest(obj)
    meshes.activate(obj)
    assert bpy.ops.meanvalue.reset_handles() == {'FINISHED'}
    update()
    assert is_at_rest(obj, 1e-3), np.abs(shown(obj) - rest(obj)).max()


def test_the_colour_of_a_line_is_that_of_its_control():
    obj, control = handles.tube()
    obj.meanvalue.anchor_groups["Top"].color = (0.1, 0.2, 0.3)
    assert np.abs(np.array(control.color)[:3] - (0.1, 0.2, 0.3)).max() < 1e-5


def test_the_control_is_shown_in_the_mirrored_object():
    obj, control = handles.tube()
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
