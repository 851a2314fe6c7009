# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles, pins and what becomes of a pose: the operators, each by its synchronous way."""

import functools

import bpy
import numpy as np
import pytest
from support import handles, meshes, steps, take_files
from support.handles import TOP, is_at_rest, move, rest, shown, update
from support.sheets import COLUMNS, MIDDLE, grab, region_weights, sheet


def test_a_handle_of_selected_vertices_and_what_was_made_for_it_goes_with_it():
    obj = meshes.tube(17, 8)
    steps.select_in_edit_mode(obj, TOP)
    assert bpy.ops.meanvalue.add_handle(name="Head") == {'FINISHED'}
    (handle,) = obj.meanvalue.handles
    control = handle.control
    assert (handle.name, handle.follows, handle.made_control) == ("Head", 'CONTROL', True)
    assert steps.held(obj, "Head") == list(TOP) and not obj.vertex_groups
    assert obj.mode == 'OBJECT'
    assert bpy.context.object == control and control.select_get() and not obj.select_get()
    assert control.parent == obj and control.show_in_front
    assert np.allclose(control.matrix_world.translation, np.array([obj.data.vertices[i].co for i in TOP]).mean(axis=0))
    assert 0.5 < control.empty_display_size < 2.0  # the tube's radius is 1
    assert bpy.ops.meanvalue.remove_handle() == {'FINISHED'}
    assert [each.name for each in bpy.data.objects] == ["Tube"] and len(obj.meanvalue.handles) == 0
    assert bpy.context.object == obj


def test_a_control_stands_where_a_moved_and_turned_object_shows_the_part():
    obj = meshes.tube(17, 8)
    obj.location, obj.rotation_euler, obj.scale = (1.0, 2.0, 3.0), (0.5, 0.6, 0.7), (2.0, 2.0, 2.0)
    update()
    steps.add_handle(obj, "Top", TOP)
    update()
    centre = np.mean([obj.matrix_world @ obj.data.vertices[i].co for i in TOP], axis=0)
    assert np.allclose(bpy.context.object.matrix_world.translation, centre, atol=1e-5)
    assert is_at_rest(obj)


def test_a_pin_of_selected_vertices_with_a_control_active():
    obj, control = handles.tube()
    meshes.activate(obj)
    steps.select_in_edit_mode(obj, [64, 65])
    assert bpy.ops.meanvalue.add_handle(pin=True) == {'FINISHED'}
    handle = obj.meanvalue.handles[-1]
    assert (handle.name, handle.follows, handle.control) == ("Left Pin", 'REST', None)
    meshes.activate(control)
    update()
    move(control, (2.0, 0.0, 0.0))
    assert np.array_equal(shown(obj)[[64, 65]], rest(obj)[[64, 65]])


def test_a_handle_on_a_posed_mesh_does_not_move_it():
    obj, control = handles.tube()
    move(control, (3.0, 0.0, -2.0))
    before = shown(obj)
    steps.add_group(obj, "Middle", range(64, 72))
    steps.run(obj, "add_handle", group="Middle")
    update()
    assert np.abs(shown(obj) - before).max() < 0.1  # a ring is held as a rigid piece from here on
    assert np.abs(before[64:72] - rest(obj)[64:72]).max() > 0.5


@pytest.mark.parametrize("pin", [False, True])
def test_what_cannot_be_a_handle_is_refused(pin):
    obj = meshes.tube()
    call = functools.partial(bpy.ops.meanvalue.add_handle, pin=pin)
    with steps.refused("Select vertices in Edit Mode first"):
        call()
    steps.add_group(obj, "Other", [0])
    with steps.refused("no vertex group 'Nowhere'"):
        call(group="Nowhere")
    steps.add_group(obj, "Empty", [])
    with steps.refused("'Empty' has no vertices"):
        call(group="Empty")
    steps.add_group(obj, "Top", range(64, 72))
    assert call(group="Top") == {'FINISHED'}
    meshes.activate(obj)
    with steps.refused("'Top' is on the list already"):
        call(group="Top")
    steps.select_in_edit_mode(obj, [])
    with steps.refused("No vertices are selected"):
        call()
    assert obj.mode == 'EDIT'


@pytest.mark.parametrize("order", [("name", "made_group"), ("made_group", "name")])
@pytest.mark.parametrize("chosen", [(), ("Mine",), ("Mine", "Head")])
def test_a_group_that_was_made_goes_with_its_handle_unless_the_artist_chose_one(order, chosen):
    obj = meshes.tube(17, 8)
    steps.add_group(obj, "Head", TOP)
    steps.add_group(obj, "Mine", TOP)
    handle = obj.meanvalue.handles.add()
    for name in order:
        setattr(handle, name, "Head")
    for name in chosen:
        handle.name = name
    bpy.ops.meanvalue.remove_handle()
    assert obj.vertex_groups.keys() == (["Head", "Mine"] if chosen else ["Mine"])


def test_removing_a_handle_leaves_what_was_there_before():
    obj, _control = handles.tube()
    other = meshes.new_object("Mine")
    bpy.ops.meanvalue.remove_handle()
    assert "Top" in obj.vertex_groups
    obj.vertex_groups.active_index = obj.vertex_groups["Top"].index
    bpy.ops.meanvalue.add_handle()
    made = obj.meanvalue.handles["Top"].control
    obj.meanvalue.handles["Top"].control = other
    meshes.activate(obj)
    bpy.ops.meanvalue.remove_handle()
    assert bpy.data.objects.get("Mine") == other
    assert made.name in bpy.data.objects  # it may be in use elsewhere by now


def test_selecting_a_handle():
    obj, control = handles.tube()
    steps.run(obj, "select_handle", index=1)
    assert bpy.context.object == control
    assert bpy.ops.meanvalue.select_handle(index=0) == {'FINISHED'}
    assert (bpy.context.object, obj.mode) == (obj, 'EDIT')
    obj.update_from_editmode()
    assert [vertex.index for vertex in obj.data.vertices if vertex.select] == list(handles.BOTTOM)
    with steps.refused("There are 2 handles"):
        bpy.ops.meanvalue.select_handle(index=7)


def test_reset_handles_puts_objects_and_bones_back():
    obj, control = handles.tube()
    start = control.matrix_world.copy()
    control.rotation_mode = 'XYZ'
    control.rotation_euler = (1.0, 2.0, 3.0)
    control.scale = (2.0, 2.0, 2.0)
    move(control, (2.0, 0.0, 0.0))
    handles.assert_reset_puts_at_rest(obj)
    assert np.allclose(control.matrix_world, start, atol=1e-5)


def test_keep_pose():
    obj, control = handles.tube()
    meshes.activate(obj)
    move(control, (2.0, 0.0, 0.0))
    posed, place = shown(obj), np.array(control.matrix_world)
    assert bpy.ops.meanvalue.keep_pose(name="Lean") == {'FINISHED'}
    key = obj.data.shape_keys.key_blocks["Lean"]
    assert np.array_equal(steps.key_positions(obj, "Lean"), posed)
    assert key.value == 1.0 and np.abs(meshes.seen(obj) - posed).max() < 1e-4  # nothing jumps
    np.testing.assert_allclose(control.matrix_world, place, atol=1e-4)
    for value in (0.5, 0.0, 1.0):
        key.value = value
        update()
        wanted = rest(obj) + value * (posed - rest(obj))
        assert np.abs(meshes.seen(obj) - wanted).max() < 1e-3  # nor counts twice
    for operator in (bpy.ops.meanvalue.keep_pose, bpy.ops.meanvalue.apply_pose):
        with steps.refused("Nothing is posed"):
            operator()
    move(control, (2.0, 0.0, 0.0))
    assert np.abs((meshes.seen(obj) - posed)[handles.TOP] - (2.0, 0.0, 0.0)).max() < 1e-3
    assert np.array_equal(steps.key_positions(obj, "Lean"), posed)
    assert bpy.ops.meanvalue.keep_pose() == {'FINISHED'}
    assert "Top Pose" in obj.data.shape_keys.key_blocks


@pytest.mark.parametrize("has_driver", [False, True])
def test_a_pose_of_keyframes_fades_as_kept_ones_come_in(has_driver, capfd, part):
    obj, control = handles.tube()
    meshes.activate(obj)
    for frame in (1, 11):
        move(control, (1.0, 0.0, 0.0))
        control.keyframe_insert("location", frame=frame)
    posed, blocks = shown(obj), obj.data.shape_keys.key_blocks
    if has_driver:
        blocks["Mean-Value"].driver_add("value").driver.expression = "1-0"
    for name in ("Gone", "Far", "Kept"):
        assert bpy.ops.meanvalue.keep_pose(name=name) == {'FINISHED'}
    assert ("does not fade" in capfd.readouterr().out) == has_driver
    if has_driver:
        assert [each.driver.expression for each in obj.data.shape_keys.animation_data.drivers] == ["1-0"]
        return
    obj.active_shape_key_index = blocks.find("Gone")
    bpy.ops.object.shape_key_remove()
    blocks["Far"].name, blocks["Mean-Value"].name = "Other", "Pose"
    assert bpy.ops.meanvalue.keep_pose(name="Far") == {'FINISHED'}  # a name that another had
    kept = part("scene.key_marks").of_role(obj.data.shape_keys, part("scene.key_marks").Role.KEPT)
    assert [key.name for key in kept] == ["Other", "Kept", "Far"]
    live = []
    for frame, value, other in ((1, 0.0, 0.0), (6, 0.5, 0.5), (7, 1.0, 0.0), (11, 0.25, 0.25)):
        bpy.context.scene.frame_set(frame)
        animated, place = steps.key_positions(obj, "Pose"), np.array(control.matrix_world)
        for name, blocks[name].value in (("Kept", value), ("Other", other)):
            blocks[name].keyframe_insert("value")
        update()
        live.append((frame, meshes.seen(obj)))
        assert np.abs(live[-1][1] - animated - (value + other) * (posed - animated)).max() < 1e-3  # nothing twice
        np.testing.assert_allclose(control.matrix_world, place, atol=1e-4)
    for operator, options in ((bpy.ops.meanvalue.bake, {"target": 'SHAPE_KEYS'}), (bpy.ops.meanvalue.unbake, {})):
        assert operator(**options) == {'FINISHED'}
        for frame, wanted in live:
            bpy.context.scene.frame_set(frame)
            assert np.abs(meshes.seen(obj) - wanted).max() < 3e-3
            assert blocks["Pose"].value == 0.0 or not options  # exporters know nothing of muted keys


ADDED = (("Smile", "Basis"), ("Laugh", "Smile"))


def test_apply_as_rest():
    obj, control = handles.tube()
    smile = obj.shape_key_add(name="Smile", from_mix=False)
    smile.data[70].co.y += 0.25
    laugh = obj.shape_key_add(name="Laugh", from_mix=False)
    laugh.relative_key, laugh.data[70].co.z = smile, 9.0
    added = [steps.key_positions(obj, key) - steps.key_positions(obj, of) for key, of in ADDED]
    move(control, (3.0, 0.0, -2.0))
    posed = shown(obj)
    assert bpy.ops.meanvalue.apply_pose() == {'FINISHED'}
    update()
    assert np.array_equal(rest(obj), posed)
    assert np.array_equal(np.array([vertex.co for vertex in obj.data.vertices], np.float32), posed)
    for (key, of), before in zip(ADDED, added, strict=True):
        assert np.abs(steps.key_positions(obj, key) - steps.key_positions(obj, of) - before).max() < 1e-5
    assert is_at_rest(obj, 1e-3)
    move(control, (0.0, 1.0, 0.0))
    assert np.abs(shown(obj)[TOP, 1] - posed[TOP, 1] - 1.0).max() < 1e-4


def test_solve_without_live_takes_the_controls():
    obj, control = handles.tube(live=False)
    move(control, (2.0, 0.0, -1.0))
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    assert bpy.ops.meanvalue.solve() == {'FINISHED'}
    assert np.abs(shown(obj)[TOP, 0] - rest(obj)[TOP, 0] - 2.0).max() < 1e-5
    handle = obj.meanvalue.handles["Top"]
    handle.control = None
    meshes.activate(obj)
    with steps.refused("Handle 'Top' has no control"):
        bpy.ops.meanvalue.solve()


def test_the_methods_of_the_paper_are_there():
    obj, control = handles.tube(live=False)
    move(control, (1.0, 0.0, 0.0))
    results = {}
    for method in ('fast', 'paper', 'full'):
        obj.meanvalue.method = method
        assert bpy.ops.meanvalue.bind() == {'FINISHED'}
        assert bpy.ops.meanvalue.solve() == {'FINISHED'}
        results[method] = shown(obj)
    assert np.abs(results["fast"] - results["full"]).max() > 1e-3
    assert np.abs(results["paper"] - results["full"]).max() > 1e-6


@pytest.mark.parametrize("live", [False, True])
def test_a_soft_handle_without_influence_is_free(live):
    obj, control, _ = handles.three_handles(live=live)
    handle = obj.meanvalue.handles["Top"]
    handle.is_soft, handle.strength = True, 1.0

    def moved_by():
        update()
        if not live:
            assert bpy.ops.meanvalue.solve() == {'FINISHED'}
        return float(np.abs(shown(obj) - rest(obj))[TOP].max())

    move(control, (1.0, 0.0, 0.0))
    assert live or bpy.ops.meanvalue.bind() == {'FINISHED'}
    pulled = moved_by()
    control.meanvalue.influence = 0.0
    freed = moved_by()
    control.meanvalue.influence = 1.0
    assert pulled > 0.3
    assert freed < 0.1 * pulled
    assert abs(moved_by() - pulled) < 0.05 * pulled


def test_keyframes_on_all_controls_at_the_current_frame():
    obj = sheet()
    grab()
    meshes.activate(obj)
    grab(vertex=3 * COLUMNS + 3, size=0.1)
    bpy.context.scene.frame_set(7)
    assert bpy.ops.meanvalue.keyframe_handles() == {'FINISHED'}
    for handle in obj.meanvalue.handles:
        curves = take_files.curves(handle.control)
        assert {(curve.data_path, curve.array_index) for curve in curves} == {
            (path, index) for path in ("location", "rotation_euler", "scale") for index in range(3)
        }
        assert all([key.co.x for key in curve.keyframe_points] == [7.0] for curve in curves)


def test_live_is_not_turned_on_without_handles():
    obj = meshes.grid()
    lamp = meshes.new_object("Lamp", bpy.data.lights.new("Lamp", 'POINT'))
    for active in (obj, lamp):
        meshes.activate(active)
        assert bpy.ops.wm.context_toggle(data_path="scene.meanvalue_live") == {'FINISHED'}  # as the shortcut does
    assert not obj.meanvalue.live


def test_add_handle_gives_the_region_a_size():
    obj = sheet()
    steps.add_handle(obj, "Top", [MIDDLE, MIDDLE + 1], size=0.2)
    weights = region_weights(obj)
    assert weights[MIDDLE] == weights[MIDDLE + 1] == 1.0
    assert (np.diff(weights[MIDDLE + 1 : MIDDLE + 14]) <= 0.0).all() and weights[MIDDLE + 14] == 0.0


@pytest.mark.parametrize("held", [[[k] for k in range(8)], [[4, 5, 6, 7], [0, 1, 2, 3]]])
@pytest.mark.parametrize("is_pin", [False, True])
def test_where_all_is_held_each_handle_goes_where_it_is_told(held, is_pin):
    corners = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    sides = [(k, (k + 1) % 4, (k + 1) % 4 + 4, k + 4) for k in range(4)]
    obj = meshes.make_object(corners, [(3, 2, 1, 0), (4, 5, 6, 7), *sides], "Cube")
    controls = []
    for members in held:
        meshes.activate(obj)
        controls.append(steps.add_handle(obj, f"Held {members}", members, pin=is_pin and len(controls) > 0))
    move(controls[0], (0.0, 0.0, 0.5))
    for _ in range(2):
        moved = shown(obj) - rest(obj)
        assert np.allclose(moved[held[0]], (0.0, 0.0, 0.5), atol=1e-6)
        assert not np.delete(moved, held[0], axis=0).any()
        meshes.activate(obj)
        steps.solve()
    assert bpy.ops.meanvalue.bake(target='SHAPE_KEYS', frame_range='OWN', frame_start=1, frame_end=3) == {'FINISHED'}
    assert np.allclose(shown(obj), rest(obj) + moved, atol=1e-6)
