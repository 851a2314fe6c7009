# SPDX-License-Identifier: GPL-3.0-or-later
"""Live posing goes on when what was in its way is mended."""

import contextlib

import bpy
import pytest
from support import armatures, handles, meshes, steps
from support.handles import BOTTOM, TOP, follows, move, rest, shown, three_handles, update


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
    twin = meshes.duplicate(obj, linked=True)
    handle = twin.meanvalue.handles["Top"]
    other = meshes.new_object("Other")
    other.location = control.matrix_world.translation
    handle.control = other
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
    handle = obj.meanvalue.handles["Top"]
    handle.control = rig
    handle.bone = "Bone"
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
    obj, control, middle = three_handles()
    move(control, (1.0, 0.0, 0.0))
    obj.meanvalue.active_handle = 0
    assert bpy.ops.meanvalue.remove_handle() == {'FINISHED'}
    update()
    move(control, (1.0, 0.0, 0.0))
    assert follows(obj, (0, 0, 0), middle), shown(obj)[middle][:2] - rest(obj)[middle][:2]
    assert follows(obj, (2, 0, 0), TOP)


@pytest.mark.parametrize("way", ["removed", "deleted", "off"])
@pytest.mark.parametrize("has_pin", [False, True])
def test_the_mesh_is_at_rest_once_nothing_moves_it(way, has_pin):
    obj = meshes.tube(handles.RINGS, handles.SEGMENTS, "Tube")
    if has_pin:
        steps.add_handle(obj, "Bottom", BOTTOM, pin=True)
    control = steps.add_handle(obj, "Top", TOP, live=True)
    update()
    move(control, (1.0, 0.0, 0.0))
    assert follows(obj, (1, 0, 0))
    if way == "removed":
        steps.run(obj, "remove_handle")
    elif way == "deleted":
        control.users_collection[0].objects.unlink(control)
    else:
        obj.meanvalue.handles["Top"].is_enabled = False
    obj.update_tag()
    update()
    assert handles.is_at_rest(obj)


def test_handles_reordered_by_a_script():
    obj, control, _middle = three_handles()
    obj.meanvalue.handles.move(2, 0)
    move(control, (1.0, 0.0, 0.0))
    assert follows(obj, (0, 0, 0), BOTTOM), "the pin was moved by the handle's control"
    assert follows(obj, (1, 0, 0), TOP)


def test_an_animated_handle_is_turned_off():
    obj, control, middle = three_handles()
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


def test_reset_of_a_control_that_is_a_child_of_another():
    obj, control, _middle = three_handles()
    obj.meanvalue.active_handle = 1
    steps.run(obj, "remove_handle")
    obj.vertex_groups.active_index = obj.vertex_groups["Middle"].index
    assert bpy.ops.meanvalue.add_handle(group="Middle") == {'FINISHED'}
    update()
    child = obj.meanvalue.handles["Middle"].control
    child.parent = control
    child.matrix_parent_inverse = control.matrix_world.inverted()
    update()
    move(control, (1.0, 0.0, 0.0))
    handles.assert_reset_puts_at_rest(obj)


def test_a_movie_that_cannot_be_written_does_not_stop_it_for_ever():
    obj, control = handles.tube()
    scene = steps.scene_to_render("/proc/nowhere/x.mp4")
    if hasattr(scene.render.image_settings, "media_type"):  # Blender 5.0 and later
        scene.render.image_settings.media_type = 'VIDEO'
    scene.render.image_settings.file_format = 'FFMPEG'
    scene.render.ffmpeg.format = 'MPEG4'
    scene.render.ffmpeg.codec = 'H264'
    with contextlib.suppress(RuntimeError):
        bpy.ops.render.render(animation=True)
    move(control, (1.0, 0.0, 0.0))
    assert follows(obj, (1, 0, 0))


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
