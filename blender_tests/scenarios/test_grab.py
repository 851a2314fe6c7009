# SPDX-License-Identifier: GPL-3.0-or-later
"""The Grab tool's operators as scripts call them: handles where the mesh is pressed, pins, and Finish."""

import bpy
import numpy as np
import pytest
from support import bent_limb, handles, installed, libraries, meshes, posed_rigs, rigs, rings, steps
from support.sheets import BESIDE, COLUMNS, MIDDLE, grab, lift, pin, region_weights, sheet
from support.snapshot import assert_same, snapshot


def test_a_fresh_mesh_is_grabbed_and_its_surroundings_follow_less_and_less():
    obj = sheet()
    grab()
    handle = obj.meanvalue.handles[0]
    assert obj.meanvalue.live and bpy.context.object == obj and bpy.context.selected_objects == [handle.control]
    assert lift(obj)[MIDDLE] == pytest.approx(2.0, abs=1e-4)
    row = lift(obj)[MIDDLE : MIDDLE + 15]
    assert (np.diff(row) <= 2e-3).all() and row[14] == 0.0
    weights = region_weights(obj)
    assert ((weights > 0.0) & (weights < 1.0)).sum() > 50
    assert not lift(obj)[weights == 0.0].any()


def test_a_loose_part_within_size_goes_along_whole():
    """A square beside the middle, just above the sheet, and one at the border."""
    flat = np.array([(x, y, 0.0) for y in range(COLUMNS) for x in range(COLUMNS)], float)
    corners = np.array([(-0.4, -0.4, 0.3), (0.4, -0.4, 0.3), (0.4, 0.4, 0.3), (-0.4, 0.4, 0.3)])
    places = [flat[MIDDLE] + (1.0, 0.0, 0.0), flat[0]]
    faces = [(i, i + 1, i + COLUMNS + 1, i + COLUMNS) for i in range(len(flat) - COLUMNS) if (i + 1) % COLUMNS]
    squares = [range(len(flat) + 4 * k, len(flat) + 4 * k + 4) for k in range(2)]
    vertices = np.concatenate([flat, *(place + corners for place in places)])
    obj = meshes.make_object(vertices.tolist(), faces + [tuple(square) for square in squares], "Buttons")
    grab()
    near, far = (lift(obj)[list(square)] for square in squares)
    assert near.mean() == pytest.approx(lift(obj)[MIDDLE + 1], rel=0.05), "as far as what is under it"
    lengths = np.linalg.norm(np.diff(handles.shown(obj)[list(squares[0])], axis=0), axis=1)
    assert lengths == pytest.approx([0.8, 0.8, 0.8], abs=0.1), "as a piece"
    assert not far.any()


def tubes(*layers):
    """A limb along z of 41 rows of 16 vertices for each (scale, shift); and how far each vertex of them has gone."""
    turns = np.radians(np.arange(0.0, 360.0, 22.5))
    vertices = np.array([(0.2 * np.cos(turn), 0.2 * np.sin(turn), 0.05 * row) for row in range(41) for turn in turns])
    faces = rings.quads(41, 16)
    vertices = np.concatenate([vertices * scale + shift for scale, shift in layers])
    faces = np.concatenate([faces + 656 * k for k in range(len(layers))])
    obj = meshes.make_object(vertices.tolist(), faces.tolist(), "Limbs")
    return obj, lambda: (handles.shown(obj) - handles.rest(obj)).reshape(len(layers), 41, 16, 3)


END = 656 - 8


@pytest.mark.parametrize("outer, size", [(1.0, 0.4), (1.025, 0.4), (1.025, 0.05)])
def test_layers_go_alike_and_a_limb_beside_stays(outer, size):
    """A tube, one in its place or just outside, as clothes are, and one beside them that is nearer than Size."""
    obj, moves = tubes((1.0, (0.0, 0.0, 0.0)), ((outer, outer, 1.0), (0.0, 0.0, 0.0)), (1.0, (0.45, 0.0, 0.0)))
    grab(vertex=END, offset=(0.4, 0.0, 0.1), size=size)
    inner, over, beside = moves()
    assert np.abs(inner).max() > 0.3 and not beside.any()
    assert np.abs(inner - over).max() < 0.02, "about what the outer one is wider by"
    weights = region_weights(obj).reshape(3, -1)
    assert np.abs(weights[0] - weights[1]).max() < 0.02 and not weights[2].any()


@pytest.mark.parametrize("thickness", [0.01, 0.05])
def test_both_walls_of_a_shell_go_alike(thickness):
    """One piece, pressed far from its rims: Solidify applied."""
    obj, _moves = tubes((1.0, (0.0, 0.0, 0.0)))
    obj.modifiers.new("Walls", 'SOLIDIFY').thickness = thickness
    bpy.ops.object.modifier_apply(modifier="Walls")
    grab(vertex=16 * 20 + 8, offset=(-0.2, 0.0, 0.2), size=0.2)
    outer, inner = (handles.shown(obj) - handles.rest(obj)).reshape(2, -1, 3)
    assert np.abs(outer).max() > 0.19 and np.abs(outer - inner).max() < 0.01 + thickness


@pytest.mark.parametrize("pressed", [END, 16 * 28 + 8, 16 * 81 + 8])
def test_a_sleeve_goes_along_beyond_size_and_that_of_a_limb_beside_stays(pressed):
    """Wider than what nearly touches, pressed beyond it, on the arm within it, and on its end."""
    worn, band = ((1.15, 1.15, 0.6), (0.0, 0.0, 0.4)), ((1.15, 1.15, 0.1), (0.5, 0.0, 1.6))
    obj, moves = tubes((1.0, (0.0, 0.0, 0.0)), worn, (1.0, (0.5, 0.0, 0.0)), band)
    grab(vertex=pressed, offset=(-0.3, 0.0, 0.05), size=0.3)
    arm, sleeve, *others = moves()
    assert np.abs(arm).max() > 0.25 and not np.any(others)
    assert np.abs(sleeve[40] - arm[32]).max() < 0.06 < np.abs(arm[32]).max(), "its end is where the arm is below it"
    assert np.abs(sleeve[:8]).max() < 2e-3, "and its beginning stays"
    weights = region_weights(obj).reshape(4, -1)
    assert (weights[1] == 1.0).all() and not weights[2:].any() and (weights[0] == 0.0).any()


def test_a_size_below_one_edge_still_has_something_follow():
    obj = sheet()
    grab(size=0.005)
    assert np.count_nonzero(lift(obj)) > 4


def test_a_second_grab_elsewhere_keeps_the_first():
    obj = sheet()
    grab()
    before = lift(obj)
    grab(vertex=3 * COLUMNS + 3, offset=(0.0, 0.0, -1.0), size=0.1)
    assert len(obj.meanvalue.handles) == 2
    assert lift(obj)[3 * COLUMNS + 3] == pytest.approx(-1.0, abs=1e-4)
    assert np.abs(lift(obj) - before)[np.abs(before) > 1e-4].max() < 1e-4


def test_a_grab_beside_a_posed_handle_begins_from_what_is_seen():
    obj = sheet()
    grab(size=0.4)
    before = lift(obj)[MIDDLE + 5]
    assert before > 0.3
    grab(vertex=MIDDLE + 5, offset=(0.0, 0.0, 0.5))
    assert lift(obj)[MIDDLE + 5] == pytest.approx(before + 0.5, abs=0.05)
    assert lift(obj)[MIDDLE] == pytest.approx(2.0, abs=1e-3)


def test_size_of_a_handle_that_is_there_widens_and_narrows_what_follows():
    obj = sheet()
    grab(vertex=3 * COLUMNS + 3, size=0.1)
    corner = region_weights(obj)
    grab(size=0.1)
    narrow = region_weights(obj)
    grab(offset=(0.0, 0.0, 0.0), size=0.3)
    assert (region_weights(obj) > 0.0).sum() > 2 * (narrow > 0.0).sum()
    grab(offset=(0.0, 0.0, 0.0), size=0.1)
    assert np.array_equal(region_weights(obj), narrow)
    assert (region_weights(obj) >= corner).all(), "the other handle's"
    assert lift(obj)[MIDDLE] == pytest.approx(2.0, abs=1e-3)
    grab(offset=(0.0, 0.0, 1.0))
    assert np.array_equal(region_weights(obj), narrow), "untold, Size stays as it is"


def test_a_mesh_that_another_live_object_poses_is_refused_before_anything_is_made():
    obj = sheet()
    grab()
    other = meshes.new_object("Other", obj.data)
    meshes.activate(other)
    with steps.refused("'Sheet' has the same mesh and is live", unchanged=other):
        bpy.ops.meanvalue.grab(vertex=3 * COLUMNS + 3, offset=(0.0, 0.0, 1.0))
    meshes.activate(obj)
    grab(offset=(0.0, 0.0, 1.0))
    assert lift(obj)[MIDDLE] == pytest.approx(3.0, abs=1e-3), "the one that poses it goes on"


def test_a_control_that_is_linked_is_not_dragged(tmp_path):
    control = libraries.linked(tmp_path, bpy.data.objects.new("Far", None), "objects")
    obj = sheet()
    steps.add_group(obj, "Hand", [MIDDLE])
    handle = obj.meanvalue.handles.add()
    handle.name, handle.follows = "Hand", 'CONTROL'
    handle.control = control
    with steps.refused("'Hand'", unchanged=obj):
        bpy.ops.meanvalue.grab(vertex=MIDDLE, offset=(0.0, 0.0, 1.0))
    assert control.location.length == 0.0


def test_another_object_than_the_active_one_becomes_it():
    """As Adjust Last Operation calls it, from before the press."""
    obj, other = sheet(), meshes.grid(5, 5, "Other")
    meshes.activate(other)
    grab(object_name="Sheet")
    assert len(obj.meanvalue.handles) == 1 and bpy.context.object == obj
    pin(0, object_name="Other")
    assert len(other.meanvalue.handles) == 1 and bpy.context.object == other


def test_the_end_of_a_limb_turns_with_it_and_comes_back():
    vertices, faces = bent_limb.limb(16, 60)
    obj = meshes.make_object(vertices.tolist(), faces, "Limb")
    tip, angle = 55 * 16, np.radians(50.0)
    around = 2.0 * np.array([np.cos(angle) - 1.0, 0.0, np.sin(angle)])
    grab(vertex=tip, offset=around, size=0.35)
    control = obj.meanvalue.handles[0].control
    assert 30.0 < np.degrees(control.matrix_world.to_quaternion().angle) < 80.0
    assert np.abs(handles.shown(obj)[tip] - (vertices[tip] + around)).max() < 1e-3, "the mouse keeps what it has"
    control.rotation_euler.x += 0.5
    handles.update()
    turned = control.matrix_world.copy()
    grip = take_hold(obj, tip)
    for offset in ((0.5, 0.0, 0.8), (0.0, 0.0, 0.0)):
        grip.move(obj, np.array(offset))
        handles.update()
    assert np.allclose(control.matrix_world, turned, atol=1e-5), "R by the artist stays"


def test_the_end_of_a_limb_of_a_mirrored_object_turns_as_well():
    vertices, faces = bent_limb.limb(16, 60)
    obj = meshes.make_object(vertices.tolist(), faces, "Limb")
    obj.scale = (-1.0, -1.0, -1.0)
    handles.update()
    grab(vertex=55 * 16, offset=(0.7, 0.0, -1.5), size=0.35)
    turn = obj.meanvalue.handles[0].control.rotation_euler.to_quaternion()
    assert 0.3 < turn.angle < 3.0


def test_the_surroundings_of_a_removed_handle_are_held_again():
    obj = sheet()
    grab()
    first = region_weights(obj)
    grab(vertex=3 * COLUMNS + 3, offset=(0.0, 0.0, -1.0), size=0.1)
    assert (region_weights(obj) > 0.0).sum() > (first > 0.0).sum()
    meshes.activate(obj)
    for left in (first, None):
        obj.meanvalue.active_handle = len(obj.meanvalue.handles) - 1
        assert bpy.ops.meanvalue.remove_handle() == {'FINISHED'}
        if left is None:
            assert obj.meanvalue.roi_group == "" and len(obj.vertex_groups) == 0
        else:
            assert np.array_equal(region_weights(obj), left)


def test_pins_stay_and_are_let_go_again():
    obj = sheet()
    pin(BESIDE - 4)
    grab(size=0.5)
    assert lift(obj)[BESIDE - 4] == 0.0
    assert lift(obj)[MIDDLE - 5] > 0.1
    assert obj.meanvalue.handles[0].follows == 'REST'
    pin(BESIDE - 4)
    assert [handle.follows for handle in obj.meanvalue.handles] == ['CONTROL']
    assert "Pin" not in obj.vertex_groups
    assert lift(obj)[BESIDE - 4] > 0.1


def test_a_pin_where_the_mesh_is_posed_holds_it_there():
    obj = sheet()
    grab(size=0.5)
    before = lift(obj)[MIDDLE + 5]
    pin(MIDDLE + 5, size=0.01)
    meshes.activate(obj)
    grab(offset=(0.0, 0.0, 2.0))
    assert lift(obj)[MIDDLE] == pytest.approx(4.0, abs=1e-3)
    assert lift(obj)[MIDDLE + 5] == pytest.approx(before, abs=1e-3)


@pytest.mark.parametrize("vertex, text", [(MIDDLE, "Pin' is pinned here"), (COLUMNS**2, "no face at this vertex")])
def test_pins_and_loose_vertices_are_not_dragged(vertex, text):
    obj = sheet()
    obj.data.vertices.add(1)
    pin(MIDDLE)
    with steps.refused(text, unchanged=obj):
        bpy.ops.meanvalue.grab(vertex=vertex, offset=(0.0, 0.0, 1.0))


def test_the_artists_own_group_is_not_written_to():
    obj = sheet()
    steps.add_group(obj, "Painted", range(100), 0.5)
    obj.meanvalue.roi_group = "Painted"
    painted = region_weights(obj)
    grab(size=0.1)
    assert obj.meanvalue.roi_group == "Region"
    assert np.allclose(np.maximum(region_weights(obj), painted)[:100], region_weights(obj)[:100], atol=1 / 255)
    steps.run(obj, "finish")
    obj.meanvalue.roi_group = "Painted"
    assert obj.vertex_groups.keys() == ["Painted"] and np.array_equal(region_weights(obj), painted)


# Esc


def take_hold(obj, vertex=MIDDLE):
    return installed.part("posing.bridge.grip").Grip(obj, vertex, 0.2)


def test_a_first_grab_that_is_taken_back_leaves_no_key_where_live_was_on():
    obj = sheet()
    obj.meanvalue.live = True
    grip = take_hold(obj)
    grip.move(obj, np.array((0.0, 0.0, 1.0)))
    handles.update()
    assert obj.data.shape_keys is not None
    grip.take_back(obj)
    handles.update()
    assert obj.data.shape_keys is None and obj.meanvalue.live and len(obj.meanvalue.handles) == 0


@pytest.mark.parametrize("name", ["", "Painted", "Gone"])
def test_taken_back_region_keys_and_groups_are_as_before(name):
    obj = sheet()
    steps.add_group(obj, "Last", [1])
    steps.add_group(obj, "Painted", range(100))
    obj.vertex_groups.active_index = 0
    obj.shape_key_add(name="Basis")
    obj.shape_key_add(name="Smile").value = 0.7
    key = obj.shape_key_add(name="Mean-Value")
    key.slider_min, key.slider_max, key.value, key.mute = 0.25, 0.5, 0.375, True
    key.vertex_group, key.relative_key = "Last", obj.data.shape_keys.key_blocks["Smile"]
    obj.meanvalue.roi_group = name
    before = snapshot(obj)
    take_hold(obj).take_back(obj)
    assert_same(before, snapshot(obj))


@pytest.mark.parametrize("holder", ["driver", "constraint", "nothing"])
def test_a_handle_that_something_else_holds_is_not_said_to_have_moved(capfd, holder):
    obj = sheet()
    grab()
    control = obj.meanvalue.handles[0].control
    if holder == "driver":
        for index in range(3):
            control.driver_add("location", index).driver.expression = str(control.location[index])
    if holder == "constraint":
        post = meshes.new_object("Post")
        post.matrix_world = control.matrix_world
        control.constraints.new('COPY_TRANSFORMS').target = post
    handles.update()
    before = control.matrix_world.copy()
    capfd.readouterr()
    meshes.activate(obj)
    grab(offset=(0.0, 0.0, 1.0))
    said = capfd.readouterr().out
    is_held = holder != "nothing"
    assert is_held == ((control.matrix_world.translation - before.translation).length < 1e-6)
    assert is_held == ("Something else moves its control" in said)


# On rigs


@pytest.mark.parametrize("make", [posed_rigs.linear, posed_rigs.lattice, posed_rigs.other_keys, posed_rigs.all_at_once])
def test_what_is_seen_goes_where_it_is_dragged(make):
    obj, _ = make()
    before = rigs.seen(obj)
    vertex = rigs.TOP[0]
    steps.run(obj, "grab", vertex=vertex, offset=(0.3, -0.2, 0.4))
    handles.update()
    moved = rigs.seen(obj) - before
    assert np.abs(moved[vertex] - (0.3, -0.2, 0.4)).max() < 1e-4 * rigs.size(obj)
    assert np.abs(moved[rigs.BOTTOM]).max() < 1e-4 * rigs.size(obj)


def test_without_faces_nothing_is_grabbed():
    bpy.ops.mesh.primitive_circle_add()
    with steps.refused("no faces"):
        bpy.ops.meanvalue.grab(vertex=0, offset=(0.0, 0.0, 0.5))
    assert not bpy.context.object.meanvalue.handles


@pytest.mark.parametrize("far, move, is_told", [(30.0, 0.01, False), (1e3, 5e-4, True), (1e6, 0.5, True)])
def test_far_from_the_origin_a_grab_follows_or_the_distance_is_told(far, move, is_told, capfd):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=16)
    obj = bpy.context.object
    for vertex in obj.data.vertices:
        vertex.co.y += far
    top = int(np.argmax([vertex.co.z for vertex in obj.data.vertices]))
    assert bpy.ops.meanvalue.grab(vertex=top, offset=(move, 0.0, 0.0), size=0.4) == {'FINISHED'}
    handles.update()
    told = [capfd.readouterr().out, str(installed.part("live.engine").status(obj))]
    assert [f"{far:,.0f}"[:-1] in each and "Set Origin" in each for each in told] == [is_told] * 2
    assert is_told or handles.shown(obj)[top, 0] == pytest.approx(move, abs=1e-4)
