# SPDX-License-Identifier: GPL-3.0-or-later
"""Live posing of odd objects, odd keys and odd orders of events; what is used of a pose by other operators."""

import contextlib

import bpy
import numpy as np
import pytest
from mathutils import Color
from support import armatures, handles, meshes, steps
from support.handles import BOTTOM, TOP, follows, is_at_rest, move, rest, shown, update


def test_add_handle_on_a_mesh_with_coordinates_that_are_not_numbers():
    obj = meshes.tube(handles.RINGS, handles.SEGMENTS, "Tube")
    steps.add_group(obj, "Top", TOP)
    obj.data.vertices[TOP[0]].co.x = float("nan")
    with pytest.raises(RuntimeError) as error:
        bpy.ops.meanvalue.add_handle(group="Top")
    assert "Traceback" not in str(error.value), str(error.value)[-300:]
    assert len(obj.meanvalue.handles) == 0


@pytest.mark.parametrize("name", ["é" * 31 + "x", "手" * 21, "a" * 63, "x'\"\\[]", "100%s {0}"])
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


def test_odd_matrices(status):
    obj, control = handles.tube()
    parent = meshes.new_object("Parent")
    parent.scale = (1.0, 3.0, 0.5)
    parent.rotation_euler = (0.3, 0.2, 0.1)
    obj.parent = parent
    obj.rotation_euler = (0.5, 0.7, 0.2)
    obj.scale = (-1.0, 2.0, 0.5)
    update()
    assert is_at_rest(obj)
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


def test_duplicate_removed_original_gives_up_control(status):
    obj, control = handles.tube()
    meshes.activate(obj)
    bpy.ops.object.duplicate()
    twin = bpy.context.object
    update()
    control.parent = None
    bpy.data.objects.remove(obj)
    update()
    move(control, (1.0, 0.0, 0.0))
    assert status(twin)[1] is False and follows(twin, (1, 0, 0)), status(twin)


def test_a_mesh_emptied_while_live(status):
    obj, control = handles.tube()
    move(control, (1.0, 0.0, 0.0))
    obj.data.clear_geometry()
    update()
    move(control, (1.0, 0.0, 0.0))
    assert status(obj)[1] is True


def test_removing_a_handle_of_a_duplicate_leaves_the_originals_control_alone(status):
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
        handle = obj.meanvalue.handles[name]
        handle.control = rig
        handle.bone = bone
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


def test_a_handle_its_points_and_its_control_are_shown_in_the_same_color():
    """Points are drawn in the handle's colour as it is; an object's is linear, and made brighter when it is shown."""
    obj, control = handles.tube()
    handle = obj.meanvalue.handles["Top"]
    assert handle.bl_rna.properties["color"].subtype == 'COLOR_GAMMA'
    made, chosen = tuple(handle.color), (0.1, 0.2, 0.3)
    assert np.abs(shown_color(control) - made).max() < 1e-4
    handle.color = chosen
    assert np.abs(shown_color(control) - chosen).max() < 1e-4


def shown_color(obj):
    return np.array(Color(obj.color[:3]).from_scene_linear_to_srgb())


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
    move(control, (1.0, 0.0, 0.0))
    layer.exclude = False
    update()
    assert abs((shown(obj) - rest(obj))[TOP[0], 0] - 1.0) < 1e-3
    assert status(obj)[1] is False


@pytest.mark.parametrize("hide", ["eye", "monitor", "tick"])
def test_a_hidden_control_is_followed_or_told_of(status, hide):
    obj, control = handles.tube()
    (home,) = control.users_collection
    move(control, (1.0, 0.0, 0.0))
    if hide == "eye":
        control.hide_set(True)
    elif hide == "monitor":
        control.hide_viewport = True
    else:
        bpy.context.view_layer.layer_collection.children[home.name].exclude = True
    move(control, (1.0, 0.0, 0.0))
    text, is_problem = status(obj)
    assert is_problem == ("excluded: 'Top'" in text) == (hide != "eye"), text
    assert handles.follows(obj, (2.0 if hide == "eye" else 1.0, 0.0, 0.0))
    meshes.activate(obj)
    with contextlib.nullcontext() if hide == "eye" else steps.refused("excluded: 'Top'"):
        bpy.ops.meanvalue.select_handle(index=1)


def test_controls_are_in_a_collection_of_their_own_that_goes_with_the_last():
    obj, control = handles.tube()
    (home,) = control.users_collection
    assert home != bpy.context.scene.collection and set(home.objects) == {control}
    home.name = "Renamed"
    bpy.context.view_layer.layer_collection.children[home.name].exclude = True
    meshes.activate(obj)
    second = steps.add_handle(obj, "Middle", handles.MIDDLE)
    assert home in second.users_collection and second.visible_get()  # where the artist sees it, too
    for _time in obj.meanvalue.handles[:]:
        meshes.activate(obj)
        bpy.ops.meanvalue.remove_handle()
    assert not len(bpy.data.collections)
