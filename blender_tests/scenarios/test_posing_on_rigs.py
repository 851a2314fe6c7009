# SPDX-License-Identifier: GPL-3.0-or-later
"""What you see is what you pose: handles of meshes behind armatures, lattices and other shape keys."""

import math

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from support import meshes, rigs, steps
from support.rigs import BOTTOM, MIDDLE, TOP, update

RESULT = "Mean-Value"
OFFSET = (0.7, -0.4, 0.9)

#: Of the mesh's size.
NEAR = 1e-4


def linear():
    obj, armature = rigs.arm()
    rigs.bend(armature, 90.0)
    return obj, armature


def dual_quaternions():
    obj, armature = rigs.arm(volume=True)
    rigs.bend(armature, 90.0)
    return obj, armature


def lattice(obj=None):
    obj = obj or meshes.tube(rigs.RINGS, rigs.SEGMENTS, "Arm")
    cage = bpy.data.objects.new("Cage", bpy.data.lattices.new("Cage"))
    bpy.context.collection.objects.link(cage)
    cage.data.points_u = cage.data.points_v = 2
    cage.data.points_w = 4
    cage.location, cage.scale = (0.0, 0.0, 4.8), (6.0, 6.0, 16.0)
    for point in cage.data.points:
        point.co_deform.x += 0.3 * point.co.z * point.co.z * 4.0
        point.co_deform.y += 0.2 * point.co.z
    obj.modifiers.new("Lattice", 'LATTICE').object = cage
    update()
    return obj, cage


def other_keys(obj=None):
    obj = obj or meshes.tube(rigs.RINGS, rigs.SEGMENTS, "Arm")
    obj.shape_key_add(name="Basis", from_mix=False)
    for name, axis in (("Thick", 0), ("Long", 2)):
        key = obj.shape_key_add(name=name, from_mix=False)
        for point in key.data:
            point.co[axis] *= 1.3
        key.value = 0.5
    update()
    return obj, None


def all_at_once():
    obj, armature = rigs.arm(volume=True)
    other_keys(obj)
    lattice(obj)
    rigs.bend(armature, 90.0)
    return obj, armature


ALL = pytest.mark.parametrize("make", [linear, dual_quaternions, lattice, other_keys, all_at_once])


@ALL
def test_the_control_is_where_the_handle_is_seen(make):
    obj, _ = make()
    before = rigs.seen(obj)
    rigs.pin(obj, "Bottom", BOTTOM)
    for name, indices in (("Top", TOP), ("Middle", MIDDLE)):
        control = rigs.handle(obj, name, indices)
        assert np.allclose(control.matrix_world.translation, before[indices].mean(axis=0), atol=NEAR * rigs.size(obj))
    assert np.abs(rigs.seen(obj) - before).max() < NEAR * rigs.size(obj)


@ALL
@pytest.mark.parametrize("part", [TOP, MIDDLE])
@pytest.mark.parametrize("live", [True, False])
def test_a_control_moves_what_is_seen_by_as_much(make, part, live):
    obj, _ = make()
    rigs.pin(obj, "Bottom", BOTTOM)
    control = rigs.handle(obj, "Part", part, live)
    before = rigs.seen(obj)
    rigs.move_in_world(control, OFFSET)
    if not live:
        meshes.activate(obj)
        assert bpy.ops.meanvalue.bind() == {'FINISHED'}
        steps.solve()
    moved = rigs.seen(obj)[part] - before[part]
    assert np.abs(moved - OFFSET).max() < NEAR * rigs.size(obj)
    assert np.abs(rigs.seen(obj)[BOTTOM] - before[BOTTOM]).max() < NEAR * rigs.size(obj)


@ALL
def test_a_control_turns_what_is_seen_about_itself(make):
    obj, _ = make()
    rigs.pin(obj, "Bottom", BOTTOM)
    control = rigs.handle(obj, "Part", MIDDLE)
    before = rigs.seen(obj)[MIDDLE]
    centre = np.array(control.matrix_world.translation)
    turn = Matrix.Rotation(0.6, 4, (0.2, 1.0, 0.4))
    control.matrix_world = Matrix.Translation(centre) @ turn @ Matrix.Translation(-centre) @ control.matrix_world
    update()
    expected = (before - centre) @ np.array(turn.to_3x3()).T + centre
    assert np.abs(rigs.seen(obj)[MIDDLE] - expected).max() < NEAR * rigs.size(obj)


@pytest.mark.parametrize("volume", [False, True])
def test_the_key_is_what_inverse_skinning_gives(volume):
    obj, armature = rigs.arm(volume)
    rigs.bend(armature, 90.0)
    rigs.pin(obj, "Bottom", BOTTOM)
    control = rigs.handle(obj, "Part", MIDDLE)
    rest = steps.key_positions(obj, "Basis").astype(np.float64)
    assert np.abs(rigs.skinned(obj, armature, rest, volume) - rigs.seen(obj)).max() < 1e-4
    rigs.move_in_world(control, OFFSET)
    shape = steps.key_positions(obj, RESULT).astype(np.float64)
    expected = rigs.skinned(obj, armature, rest, volume)[MIDDLE] + OFFSET
    assert np.abs(rigs.skinned(obj, armature, shape, volume)[MIDDLE] - expected).max() < NEAR * rigs.size(obj)


@ALL
def test_a_rig_that_moves_changes_no_key(make):
    obj, armature = make()
    rigs.pin(obj, "Bottom", BOTTOM)
    controls = [rigs.handle(obj, name, part) for name, part in (("Middle", MIDDLE), ("Top", TOP))]
    for control in controls:
        rigs.move_in_world(control, OFFSET)
    shape = steps.key_positions(obj, RESULT)
    if armature is not None and armature.type == 'ARMATURE':
        rigs.bend(armature, 0.0)
        rigs.bend(armature, -40.0)
    elif armature is not None:
        armature.data.points[0].co_deform.x += 0.5
    else:
        obj.data.shape_keys.key_blocks["Long"].value = 0.1
    update()
    update()
    assert np.array_equal(steps.key_positions(obj, RESULT), shape)


def test_the_control_goes_along_with_the_rig():
    obj, armature = rigs.arm()
    rigs.pin(obj, "Bottom", BOTTOM)
    control = rigs.handle(obj, "Top", TOP)
    rigs.bend(armature, 90.0)
    assert np.allclose(control.matrix_world.translation, rigs.seen(obj)[TOP].mean(axis=0), atol=1e-4)
    assert tuple(control.location) == pytest.approx((0.0, 0.0, 9.6))
    rigs.bend(armature, 0.0)
    assert np.allclose(control.matrix_world.translation, (0.0, 0.0, 9.6), atol=1e-4)


def test_back_at_rest_the_key_is_a_corrective():
    """The elbow, pushed out where the arm is bent, is out by the inverse of its bones' share when it is straight."""
    obj, armature = rigs.arm()
    rigs.bend(armature, 90.0)
    rigs.pin(obj, "Bottom", BOTTOM)
    rigs.pin(obj, "End", TOP)
    control = rigs.handle(obj, "Elbow", MIDDLE)
    before = rigs.seen(obj)
    rigs.move_in_world(control, OFFSET)
    rest = steps.key_positions(obj, "Basis").astype(np.float64)
    turn = np.array(armature.pose.bones["Lower"].matrix @ armature.data.bones["Lower"].matrix_local.inverted())
    rigs.bend(armature, 0.0)
    share = rigs.lower_share(obj)[MIDDLE]
    expected = [np.linalg.solve((1.0 - each) * np.eye(3) + each * turn[:3, :3], np.array(OFFSET)) for each in share]
    assert np.abs(rigs.seen(obj)[MIDDLE] - rest[MIDDLE] - expected).max() < NEAR * rigs.size(obj)
    rigs.bend(armature, 90.0)
    assert np.abs(rigs.seen(obj)[MIDDLE] - before[MIDDLE] - OFFSET).max() < NEAR * rigs.size(obj)


def test_reset_puts_the_control_to_where_the_handle_is_seen():
    obj, armature = linear()
    before = rigs.seen(obj)
    rigs.pin(obj, "Bottom", BOTTOM)
    control = rigs.handle(obj, "Part", MIDDLE)
    rigs.move_in_world(control, OFFSET)
    meshes.activate(obj)
    assert bpy.ops.meanvalue.reset_handles() == {'FINISHED'}
    update()
    assert np.allclose(control.matrix_world.translation, before[MIDDLE].mean(axis=0), atol=1e-4)
    assert np.abs(rigs.seen(obj) - before).max() < 1e-3


def test_another_control_takes_a_posed_handle_over_where_it_is_seen():
    obj, armature = linear()
    rigs.pin(obj, "Bottom", BOTTOM)
    rigs.move_in_world(rigs.handle(obj, "Part", MIDDLE), OFFSET)
    before = rigs.seen(obj)
    other = bpy.data.objects.new("Other", None)
    bpy.context.collection.objects.link(other)
    other.location = (3.0, 2.0, 1.0)
    update()
    obj.meanvalue.anchor_groups["Part"].control = other
    update()
    assert np.abs(rigs.seen(obj) - before).max() < 1e-3
    rigs.move_in_world(other, OFFSET)
    assert np.abs(rigs.seen(obj)[MIDDLE] - before[MIDDLE] - OFFSET).max() < 3.0 * NEAR * rigs.size(obj)


def test_apply_pose_keeps_what_is_seen():
    obj, armature = linear()
    rigs.pin(obj, "Bottom", BOTTOM)
    control = rigs.handle(obj, "Part", MIDDLE)
    rigs.move_in_world(control, OFFSET)
    before = rigs.seen(obj)
    meshes.activate(obj)
    assert bpy.ops.meanvalue.apply_pose() == {'FINISHED'}
    update()
    update()
    assert np.abs(rigs.seen(obj) - before).max() < 1e-3
    rigs.move_in_world(control, OFFSET)
    assert np.abs(rigs.seen(obj)[MIDDLE] - before[MIDDLE] - OFFSET).max() < NEAR * rigs.size(obj)


def bone_carries(part):
    """(object, armature, where the part is seen, n x 3): the bone that deforms the part carries its handle too."""
    obj, armature = rigs.arm()
    rigs.pin(obj, "Bottom", BOTTOM)
    rigs.handle(obj, "Part", part)
    line = obj.meanvalue.anchor_groups["Part"]
    line.control, line.bone = armature, "Lower"
    update()
    return obj, armature, rigs.seen(obj)[part]


def test_a_bone_that_deforms_its_handle_moves_it_once():
    obj, armature, before = bone_carries(TOP)
    shape = steps.key_positions(obj, RESULT)
    expected = turned_with_bone(armature, before, 50.0)
    assert np.abs(rigs.seen(obj)[TOP] - expected).max() < NEAR * rigs.size(obj)
    assert np.abs(steps.key_positions(obj, RESULT) - shape)[TOP].max() < NEAR * rigs.size(obj)  # the rig does it all


def test_a_bone_that_deforms_its_handle_in_part_moves_it_once():
    obj, armature, before = bone_carries(MIDDLE)
    expected = turned_with_bone(armature, before, 50.0)
    after = rigs.seen(obj)[MIDDLE]
    assert np.abs(after - expected).max() < NEAR * rigs.size(obj)


def turned_with_bone(armature, points, degrees):
    rest = armature.pose.bones["Lower"].matrix.copy()
    rigs.bend(armature, degrees)
    turn = np.array(armature.pose.bones["Lower"].matrix @ rest.inverted())
    return points @ turn[:3, :3].T + turn[:3, 3]


def test_a_turn_on_an_object_scaled_unevenly_does_not_shear():
    obj = meshes.tube(rigs.RINGS, rigs.SEGMENTS, "Arm")
    obj.scale = (1.0, 3.0, 0.5)
    obj.rotation_euler = (0.3, 0.2, 0.1)
    update()
    rigs.pin(obj, "Bottom", BOTTOM)
    control = rigs.handle(obj, "Top", TOP)
    world = np.array(obj.matrix_world)
    before = (rigs.seen(obj) @ world[:3, :3].T + world[:3, 3])[TOP]
    control.rotation_mode = 'XYZ'
    control.rotation_euler = (0.0, 0.0, math.radians(60.0))
    update()
    after = (rigs.seen(obj) @ world[:3, :3].T + world[:3, 3])[TOP]
    lengths = [np.linalg.norm(points[:, None] - points[None], axis=2) for points in (before, after)]
    assert np.abs(before - after).max() > 1.0
    assert np.abs(lengths[0] - lengths[1]).max() < NEAR * rigs.size(obj)
    axes = np.array(control.matrix_world.to_3x3())
    gram = axes.T @ axes
    assert np.abs(gram - np.diag(np.diag(gram))).max() < 1e-5  # the control itself is not sheared either


def test_a_turn_does_not_shear_after_the_object_was_scaled_and_the_handle_reset():
    obj, armature = linear()
    rigs.pin(obj, "Bottom", BOTTOM)
    control = rigs.handle(obj, "Part", MIDDLE)
    obj.scale = (1.0, 3.0, 0.5)
    update()
    meshes.activate(obj)
    assert bpy.ops.meanvalue.reset_handles() == {'FINISHED'}
    update()
    world = np.array(obj.matrix_world)[:3, :3]
    before = (rigs.seen(obj) @ world.T)[MIDDLE]
    control.rotation_mode = 'XYZ'
    control.rotation_euler = (0.9, 0.0, 0.5)
    update()
    after = (rigs.seen(obj) @ world.T)[MIDDLE]
    lengths = [np.linalg.norm(points[:, None] - points[None], axis=2) for points in (before, after)]
    assert np.abs(before - after).max() > 0.3
    assert np.abs(lengths[0] - lengths[1]).max() < 3.0 * NEAR * rigs.size(obj)


def test_what_makes_vertices_is_not_in_the_way():
    obj, armature = linear()
    obj.modifiers.new("Mirror", 'MIRROR').use_axis = (True, False, False)
    obj.modifiers.new("Subdivision", 'SUBSURF')
    bpy.context.view_layer.update()
    rigs.pin(obj, "Bottom", BOTTOM)
    control = rigs.handle(obj, "Part", MIDDLE)
    rest = steps.key_positions(obj, "Basis").astype(np.float64)
    rigs.move_in_world(control, OFFSET)
    shape = steps.key_positions(obj, RESULT).astype(np.float64)
    moved = rigs.skinned(obj, armature, shape)[MIDDLE] - rigs.skinned(obj, armature, rest)[MIDDLE]
    assert np.abs(moved - OFFSET).max() < NEAR * rigs.size(obj)


def test_bones_scaled_to_nothing_are_told():
    obj, armature = linear()
    rigs.pin(obj, "Bottom", BOTTOM)
    control = rigs.handle(obj, "Top", TOP, live=False)
    armature.pose.bones["Lower"].scale = (0.0, 0.0, 0.0)
    update()
    rigs.move_in_world(control, OFFSET)
    meshes.activate(obj)
    bpy.ops.meanvalue.bind()
    with steps.refused("'Armature'", "8 vertices", "'Top'", "Give the bones"):
        bpy.ops.meanvalue.solve()


def test_measuring_leaves_the_scene_alone(part):
    obj, armature = all_at_once()
    before = rigs.seen(obj)
    original = {key.name: steps.key_positions(obj, key.name) for key in obj.data.shape_keys.key_blocks}
    assert part("bridge.rig_space").measure(obj) is not None
    assert all(np.array_equal(steps.key_positions(obj, name), shape) for name, shape in original.items())
    assert [modifier.show_viewport for modifier in obj.modifiers] == [True, True]
    assert np.array_equal(rigs.seen(obj), before)
    obj.update_tag()
    update()
    assert np.array_equal(rigs.seen(obj), before)


def test_without_a_rig_nothing_is_measured(part):
    obj = meshes.tube(rigs.RINGS, rigs.SEGMENTS, "Arm")
    obj.modifiers.new("Subdivision", 'SUBSURF')
    obj.modifiers.new("Armature", 'ARMATURE').show_viewport = False
    rigs.pin(obj, "Bottom", BOTTOM)
    control = rigs.handle(obj, "Top", TOP)
    assert not part("bridge.rig_space").is_there(obj)
    rigs.move_in_world(control, OFFSET)
    assert control.matrix_parent_inverse == Matrix.Identity(4)


def test_saved_and_loaded_it_goes_on(tmp_path):
    obj, armature = linear()
    rigs.pin(obj, "Bottom", BOTTOM)
    rigs.move_in_world(rigs.handle(obj, "Part", MIDDLE), OFFSET)
    shape, before = steps.key_positions(obj, RESULT), rigs.seen(obj)
    path = str(tmp_path / "rig.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    obj = bpy.data.objects["Arm"]
    update()
    assert np.abs(steps.key_positions(obj, RESULT) - shape).max() < NEAR * rigs.size(obj)
    rigs.move_in_world(obj.meanvalue.anchor_groups["Part"].control, OFFSET)
    assert np.abs(rigs.seen(obj)[MIDDLE] - before[MIDDLE] - OFFSET).max() < 2.0 * NEAR * rigs.size(obj)


def test_undo_takes_a_move_on_a_rig_back():
    obj, armature = linear()
    rigs.pin(obj, "Bottom", BOTTOM)
    control = rigs.handle(obj, "Part", MIDDLE)
    bpy.ops.ed.undo_push(message="Before")
    before = rigs.seen(obj)
    rigs.move_in_world(control, OFFSET)
    bpy.ops.ed.undo_push(message="Moved")
    bpy.ops.ed.undo()
    obj = bpy.data.objects["Arm"]
    update()
    assert np.abs(rigs.seen(obj) - before).max() < 1e-3
    bpy.ops.ed.redo()
    obj = bpy.data.objects["Arm"]
    update()
    assert np.abs(rigs.seen(obj)[MIDDLE] - before[MIDDLE] - OFFSET).max() < NEAR * rigs.size(obj)


def test_each_frame_is_baked_with_the_rig_of_that_frame(tmp_path):
    obj, armature = rigs.arm()
    rigs.bend(armature, 90.0)
    rigs.pin(obj, "Bottom", BOTTOM)
    control = rigs.handle(obj, "Part", MIDDLE, live=False)
    rigs.move_in_world(control, OFFSET)
    place = np.array(control.matrix_world.translation)
    other = bpy.data.objects.new("Other", None)  # stays in the world, whatever the rig does
    bpy.context.collection.objects.link(other)
    other.location = place
    update()
    obj.meanvalue.anchor_groups["Part"].control = other
    rest = armature.pose.bones["Lower"]
    for frame, degrees in ((1, 90.0), (4, 30.0)):
        rest.rotation_euler = (math.radians(degrees), 0.0, 0.0)
        rest.keyframe_insert("rotation_euler", frame=frame)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 4
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "rig.blend"))
    bpy.context.scene.frame_set(1)
    before = rigs.seen(obj)[MIDDLE]
    other.location.z += 0.5
    update()
    meshes.activate(obj)
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    assert bpy.ops.meanvalue.bake() == {'FINISHED'}
    for frame in (1, 2, 3, 4):
        bpy.context.scene.frame_set(frame)
        moved = rigs.seen(obj)[MIDDLE] - before
        assert np.abs(moved - (0.0, 0.0, 0.5)).max() < 3.0 * NEAR * rigs.size(obj), frame


def test_what_is_not_seen_through_is_told_by_name(part):
    obj, armature = linear()
    obj.modifiers.new("Subdivision", 'SUBSURF')
    obj.modifiers.new("Follow", 'SURFACE_DEFORM')
    rigs.pin(obj, "Bottom", BOTTOM)
    rigs.handle(obj, "Part", MIDDLE, live=False)
    meshes.activate(obj)
    bpy.ops.meanvalue.bind()
    steps.solve()
    assert "Move 'Follow' above 'Subdivision'" in part("bridge.rig_space").note(obj)


@pytest.fixture
def override(tmp_path):
    """An override of an object of another file, whose mesh is linked."""
    meshes.tube(name="Character")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="meanvalue_deform")
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, wanted):
        wanted.objects = ["Character"]
    bpy.context.collection.objects.link(wanted.objects[0])
    obj = wanted.objects[0].override_create(remap_local_usages=True)
    update()
    meshes.activate(obj)
    return obj


def test_an_override_is_told_what_helps(override, part):
    problem = part("bridge.scene_input").object_problem(override)
    assert "override" in problem and "Pose it in the file that it comes from" in problem and "library.blend" in problem
    assert "no longer arrive" in problem  # what Make Local costs
    assert not bpy.ops.meanvalue.add_handle.poll()


def test_made_local_with_its_mesh_it_can_be_posed(override, part):
    assert bpy.ops.object.make_local(type='SELECT_OBDATA') == {'FINISHED'}
    obj = bpy.context.object
    assert part("bridge.scene_input").object_problem(obj) is None
    steps.add_group(obj, "Top", range(64, 72))
    assert bpy.ops.meanvalue.add_handle(group="Top") == {'FINISHED'}


def test_an_overridden_mesh_is_refused_since_its_keys_would_be_lost(override, part):
    override.data.override_create(remap_local_usages=True)
    assert "are not saved" in part("bridge.scene_input").object_problem(override)
