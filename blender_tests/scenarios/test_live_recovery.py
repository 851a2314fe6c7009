# SPDX-License-Identifier: GPL-3.0-or-later
"""Live posing goes on when what was in its way is mended, and follows every change of its settings."""

import contextlib

import bpy
import numpy as np
import pytest
from support import armatures, handles, meshes, steps
from support.handles import BOTTOM, TOP, move, rest, shown, three_lines, update


@pytest.fixture
def status(part):
    """status(obj): what the panel says of live posing."""
    return lambda obj: part("live.engine").status(obj) or ("", False)


def follows(obj, offset, vertices=TOP):
    return float(np.abs(shown(obj)[vertices] - rest(obj)[vertices] - np.array(offset, np.float32)).max()) < 1e-3


def assert_goes_on(obj, control, status):
    """Without a problem the handle follows its control."""
    move(control, (1.0, 0.0, 0.0))
    assert status(obj)[1] is False, status(obj)
    assert follows(obj, (1, 0, 0))


@pytest.mark.parametrize("value", [float("nan"), 1e30])
def test_it_goes_on_when_a_control_comes_back_from_where_nothing_can_be_solved(status, value):
    obj, control = handles.tube()
    place = control.location.copy()
    control.location.x = value
    update()
    control.location = place
    assert_goes_on(obj, control, status)


def test_it_goes_on_when_the_object_has_a_size_again(status):
    obj, control = handles.tube()
    obj.scale = (0.0, 0.0, 0.0)
    update()
    obj.scale = (1.0, 1.0, 1.0)
    update()
    assert_goes_on(obj, control, status)


def test_it_goes_on_when_the_control_is_in_the_scene_again(status):
    obj, control = handles.tube()
    collection = control.users_collection[0]
    collection.objects.unlink(control)
    update()
    obj.update_tag()
    update()
    collection.objects.link(control)
    update()
    assert_goes_on(obj, control, status)


def test_it_goes_on_when_the_other_object_with_the_mesh_is_no_longer_live(status):
    obj, control = handles.tube()
    twin = obj.copy()
    bpy.context.collection.objects.link(twin)
    line = twin.meanvalue.handles["Top"]
    other = bpy.data.objects.new("Other", None)
    bpy.context.collection.objects.link(other)
    other.location = control.matrix_world.translation
    line.control = other
    update()
    waiting = next(each for each in (obj, twin) if status(each)[1])
    first = obj if waiting == twin else twin
    first.meanvalue.live = False
    update()
    move(waiting.meanvalue.handles["Top"].control, (1.0, 0.0, 0.0))
    assert status(waiting)[1] is False, status(waiting)
    assert follows(waiting, (1, 0, 0))


def test_it_goes_on_when_the_bone_is_there_again(status):
    obj, _control = handles.tube()
    rig = armatures.make(Bone=((0, 0, 0), (0, 0, 1)))
    line = obj.meanvalue.handles["Top"]
    line.control = rig
    line.bone = "Bone"
    update()
    assert status(obj)[1] is False
    rig.data.bones["Bone"].name = "Renamed"
    update()
    obj.update_tag()
    update()
    rig.data.bones["Renamed"].name = "Bone"
    update()
    rig.pose.bones["Bone"].location = (1.0, 0.0, 0.0)
    update()
    assert status(obj)[1] is False, status(obj)


def test_a_pin_of_the_artists_own_group_is_removed():
    obj, control, middle = three_lines()
    move(control, (1.0, 0.0, 0.0))
    obj.meanvalue.active_handle = 0
    assert bpy.ops.meanvalue.remove_handle() == {'FINISHED'}
    update()
    move(control, (1.0, 0.0, 0.0))
    assert follows(obj, (0, 0, 0), middle), shown(obj)[middle][:2] - rest(obj)[middle][:2]
    assert follows(obj, (2, 0, 0), TOP)


def test_lines_reordered_by_a_script():
    obj, control, _middle = three_lines()
    obj.meanvalue.handles.move(2, 0)
    move(control, (1.0, 0.0, 0.0))
    assert follows(obj, (0, 0, 0), BOTTOM), "the pin was moved by the handle's control"
    assert follows(obj, (1, 0, 0), TOP)


def test_an_animated_line_is_turned_off():
    obj, control, middle = three_lines()
    path = "meanvalue.handles[0].is_enabled"
    obj.keyframe_insert(path, frame=1)
    obj.meanvalue.handles[0].is_enabled = False
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
    obj, _control = handles.tube()
    own = handles.hang_control_on_top(obj)
    update()
    places = []
    own.location.x += 0.1
    for _ in range(12):
        obj.update_tag()
        update()
        places.append(round(float(shown(obj)[TOP[0], 0] - rest(obj)[TOP[0], 0]), 3))
    assert abs(places[-1] - places[2]) < 0.2, places


def test_reset_of_a_control_that_is_a_child_of_another():
    obj, control, _middle = three_lines()
    obj.meanvalue.active_handle = 1
    meshes.activate(obj)
    assert bpy.ops.meanvalue.remove_handle() == {'FINISHED'}
    obj.vertex_groups.active_index = obj.vertex_groups["Middle"].index
    assert bpy.ops.meanvalue.add_handle(group="Middle") == {'FINISHED'}
    update()
    child = obj.meanvalue.handles["Middle"].control
    child.parent = control
    child.matrix_parent_inverse = control.matrix_world.inverted()
    update()
    move(control, (1.0, 0.0, 0.0))
    handles.assert_reset_puts_at_rest(obj)


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


@pytest.fixture
def spied_distances(part, monkeypatch):
    """Called, it gives a list that gets, with every solve from then on, how far the farthest target is from rest."""

    def start():
        session = part("solver.session")
        solve_steps, seen = session.solve_steps, []

        def spy(binding, bind_input, goal, *rest, **options):
            seen.append(float(np.abs(goal.positions - bind_input.rest[bind_input.anchors]).max()))
            return solve_steps(binding, bind_input, goal, *rest, **options)

        monkeypatch.setattr(session, "solve_steps", spy)
        return seen

    return start


def test_no_solve_of_places_that_no_control_has(spied_distances):
    obj, control = handles.tube()
    move(control, (1.0, 0.0, 0.0))
    other = bpy.data.objects.new("Other", None)
    other.location = (50.0, 0.0, 0.0)
    bpy.context.collection.objects.link(other)
    update()
    seen = spied_distances()
    obj.meanvalue.handles["Top"].control = other
    update()
    assert all(distance < 2.0 for distance in seen), seen


def test_no_solve_of_places_that_no_control_has_while_a_handle_is_made(spied_distances):
    obj, control, _middle = three_lines()
    obj.meanvalue.active_handle = 1
    meshes.activate(obj)
    assert bpy.ops.meanvalue.remove_handle() == {'FINISHED'}
    update()
    move(control, (1.0, 0.0, 0.0))
    seen = spied_distances()
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
    if hasattr(scene.render.image_settings, "media_type"):  # Blender 5.0 and later
        scene.render.image_settings.media_type = 'VIDEO'
    scene.render.image_settings.file_format = 'FFMPEG'
    scene.render.ffmpeg.format = 'MPEG4'
    scene.render.ffmpeg.codec = 'H264'
    scene.render.filepath = "/proc/nowhere/x.mp4"
    with contextlib.suppress(RuntimeError):
        bpy.ops.render.render(animation=True)
    move(control, (1.0, 0.0, 0.0))
    assert follows(obj, (1, 0, 0)), part("live.engine")._is_rendering


def test_a_file_that_cannot_be_read_does_not_stop_it(tmp_path):
    obj, control = handles.tube()
    broken = tmp_path / "broken.blend"
    broken.write_bytes(b"BLENDER-v304" + bytes(100))
    with pytest.raises(RuntimeError):
        bpy.ops.wm.open_mainfile(filepath=str(broken))
    obj = bpy.data.objects["Tube"]
    control = obj.meanvalue.handles["Top"].control
    move(control, (1.0, 0.0, 0.0))
    assert follows(obj, (1, 0, 0))
