# SPDX-License-Identifier: GPL-3.0-or-later
"""Posing on rigs: other modifiers, bones without a size, undo, files, bakes."""

import itertools
import math

import bpy
import numpy as np
import pytest
from support import handles, meshes, rigs, steps
from support.posed_rigs import all_at_once, linear, other_keys
from support.rigs import MIDDLE, NEAR, OFFSET, RESULT, TOP, update


def test_what_makes_vertices_is_not_in_the_way():
    obj, armature = linear()
    obj.modifiers.new("Mirror", 'MIRROR').use_axis = (True, False, False)
    obj.modifiers.new("Subdivision", 'SUBSURF')
    bpy.context.view_layer.update()
    control = rigs.held(obj, "Part", MIDDLE)
    rest = steps.key_positions(obj, "Basis").astype(np.float64)
    rigs.move_in_world(control, OFFSET)
    shape = steps.key_positions(obj, RESULT).astype(np.float64)
    moved = rigs.skinned(obj, armature, shape)[MIDDLE] - rigs.skinned(obj, armature, rest)[MIDDLE]
    assert np.abs(moved - OFFSET).max() < NEAR * rigs.size(obj)


def test_bones_scaled_to_nothing_are_told():
    obj, armature = linear()
    control = rigs.held(obj, "Top", TOP, live=False)
    armature.pose.bones["Lower"].scale = (0.0, 0.0, 0.0)
    update()
    rigs.move_in_world(control, OFFSET)
    meshes.activate(obj)
    bpy.ops.meanvalue.bind()
    with steps.refused("'Armature'", "'Top'"):
        bpy.ops.meanvalue.solve()


def posed():
    """(object, armature, control, the key): moved in front of a bent arm, with Live on."""
    obj, armature = linear()
    control = rigs.held(obj, "Part", MIDDLE)
    rigs.move_in_world(control, OFFSET)
    return obj, armature, control, steps.key_positions(obj, RESULT)


def test_a_rig_that_is_not_evaluated_here_is_not_taken_for_none(part):
    obj, _armature, control, shape = posed()
    control.location.x += 1.0
    scene, other = bpy.context.scene, bpy.data.scenes.new("Other")
    for each in (obj, control, *(handle.control for handle in obj.meanvalue.handles if handle.control)):
        if each.name not in other.collection.objects:
            each.users_collection[0].objects.unlink(each)
            other.collection.objects.link(each)
    update()
    part("live.engine").look_again(obj)
    part("live.engine").follow_all()
    assert np.array_equal(steps.key_positions(obj, RESULT), shape)
    assert part("live.engine").status(obj)[1]
    for each in (obj, control):
        scene.collection.objects.link(each)
    update()
    part("live.engine").follow_all()
    assert part("live.engine").status(obj) is None
    assert not np.array_equal(steps.key_positions(obj, RESULT), shape)


def test_a_rig_with_places_that_are_not_numbers_is_not_taken_for_none(part):
    obj, _armature, _control, shape = posed()
    modifier = obj.modifiers.new("Push", 'DISPLACE')
    modifier.strength = math.nan
    update()
    part("live.engine").look_again(obj)
    part("live.engine").follow_all()
    assert np.array_equal(steps.key_positions(obj, RESULT), shape)
    assert part("live.engine").status(obj)[1]
    lines = len(obj.meanvalue.handles)
    steps.add_group(obj, "Other", TOP)
    meshes.activate(obj)
    with steps.refused("not numbers"):
        bpy.ops.meanvalue.add_handle(group="Other")
    assert len(obj.meanvalue.handles) == lines


def copies(obj):
    """What the modifiers work on in Blender's evaluated copies, and which of them are on."""
    evaluated = obj.evaluated_get(bpy.context.view_layer.depsgraph)
    keys = obj.data.shape_keys
    shapes = keys.evaluated_get(bpy.context.view_layer.depsgraph).key_blocks if keys else ()
    return (
        [[tuple(point.co) for point in key.data] for key in shapes],
        [tuple(vertex.co) for vertex in obj.data.evaluated_get(bpy.context.view_layer.depsgraph).vertices],
        [modifier.show_viewport for modifier in evaluated.modifiers],
    )


@pytest.mark.parametrize("has_keys", [True, False])
def test_measuring_that_fails_leaves_no_trace(part, has_keys):
    obj = all_at_once()[0] if has_keys else rigs.arm()[0]
    rig_space, called = part("scene.rig_space"), []
    update()
    before, seen = copies(obj), rigs.seen(obj)
    bpy.app.handlers.depsgraph_update_post.append(lambda *_: called.append(1))
    with pytest.raises(ZeroDivisionError), rig_space.evaluating(obj) as evaluate:
        evaluate(np.ones((len(obj.data.vertices), 3)))
        raise ZeroDivisionError
    assert copies(obj) == before
    assert rig_space.measure(obj) is None or copies(obj) == before
    assert not called
    update()
    update()
    bpy.app.handlers.depsgraph_update_post.pop()
    assert len(called) <= 1 and copies(obj) == before  # from 4.3 on Blender evaluates once more what was written to
    assert np.array_equal(rigs.seen(obj), seen)


def test_saved_and_loaded_it_goes_on(tmp_path):
    obj, _armature = linear()
    rigs.move_in_world(rigs.held(obj, "Part", MIDDLE), OFFSET)
    shape, before = steps.key_positions(obj, RESULT), rigs.seen(obj)
    obj = steps.reopened(obj, tmp_path / "rig.blend")
    update()
    assert np.abs(steps.key_positions(obj, RESULT) - shape).max() < NEAR * rigs.size(obj)
    rigs.move_in_world(obj.meanvalue.handles["Part"].control, OFFSET)
    assert np.abs(rigs.seen(obj)[MIDDLE] - before[MIDDLE] - OFFSET).max() < 2.0 * NEAR * rigs.size(obj)


def test_each_frame_is_baked_with_the_rig_of_that_frame(tmp_path):
    obj, armature = rigs.arm()
    rigs.bend(armature, 90.0)
    control = rigs.held(obj, "Part", MIDDLE, live=False)
    rigs.move_in_world(control, OFFSET)
    place = np.array(control.matrix_world.translation)
    other = meshes.new_object("Other")  # stays in the world, whatever the rig does
    other.location = place
    update()
    obj.meanvalue.handles["Part"].control = other
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
    steps.run(obj, "bind")
    assert bpy.ops.meanvalue.bake() == {'FINISHED'}
    for frame in (1, 2, 3, 4):
        bpy.context.scene.frame_set(frame)
        moved = rigs.seen(obj)[MIDDLE] - before
        assert np.abs(moved - (0.0, 0.0, 0.5)).max() < 3.0 * NEAR * rigs.size(obj), frame


@pytest.mark.parametrize("degrees", [30.0, 70.0])
def test_behind_what_smooths_a_handle_moves_by_about_as_much(degrees):
    """A vertex that moves alone is held back by its neighbours: who makes up for that overshoots."""
    obj, armature = rigs.arm()
    obj.modifiers.new("Smooth", 'CORRECTIVE_SMOOTH')
    rigs.bend(armature, degrees)
    control = rigs.held(obj, "Part", MIDDLE)
    before = rigs.seen(obj)[MIDDLE].mean(axis=0)
    rigs.move_in_world(control, OFFSET)
    moved = rigs.seen(obj)[MIDDLE].mean(axis=0) - before
    assert np.linalg.norm(moved - OFFSET) < 0.15 * np.linalg.norm(OFFSET)


def test_what_a_pinned_key_shows_counts(part):
    obj, _ = other_keys()
    rest = steps.key_positions(obj, "Basis")
    obj.active_shape_key_index = obj.data.shape_keys.key_blocks.find("Thick")
    obj.show_only_shape_key = True
    update()
    space = part("scene.rig_space").measure(obj)
    assert np.abs(space.seen - rest * (1.3, 1.0, 1.0)).max() < 1e-5
    assert np.abs(space.jacobians - np.eye(3)).max() < 1e-4


def test_keys_relative_to_others_count(part):
    """One that is beside another, which is not shown itself."""
    obj, _ = other_keys()
    blocks = obj.data.shape_keys.key_blocks
    blocks["Long"].relative_key = blocks["Thick"]
    blocks["Thick"].value = 0.0
    update()
    rest = steps.key_positions(obj, "Basis")
    space = part("scene.rig_space").measure(obj)
    assert np.abs(space.seen - rest * (0.85, 1.0, 1.15)).max() < 1e-5
    assert np.abs(space.jacobians - np.eye(3)).max() < 1e-4


@pytest.mark.skipif(not hasattr(bpy.types, "GeometryNodeSimulationInput"), reason="no simulations in nodes yet")
@pytest.mark.parametrize("live", [False, True])
def test_a_simulation_in_nodes_is_not_asked_what_it_does(live):
    """It would go on from where it was asked for."""
    obj, control = handles.tube(live=live)
    tree = bpy.data.node_groups.new("Rise", 'GeometryNodeTree')
    for way in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=way, socket_type='NodeSocketGeometry')
    names = ("NodeGroupInput", "GeometryNodeSimulationInput", "GeometryNodeSetPosition", "GeometryNodeSimulationOutput")
    nodes = [tree.nodes.new(name) for name in (*names, "NodeGroupOutput")]
    nodes[1].pair_with_output(nodes[3])
    nodes[2].inputs["Offset"].default_value = (0.0, 0.0, 0.1)
    for one, other in itertools.pairwise(nodes):
        tree.links.new(one.outputs["Geometry"], other.inputs["Geometry"])
    obj.modifiers.new("Rise", 'NODES').node_group = tree
    for frame, offset in ((1, 0.0), (6, 1.0)):
        control.location.x = offset
        control.keyframe_insert("location", frame=frame)
    for frame in range(1, 7):
        bpy.context.scene.frame_set(frame)
        obj.update_tag()
        update()
        risen = meshes.seen(obj)[0] - obj.data.vertices[0].co  # of the pin
        assert np.allclose(risen, (0.0, 0.0, 0.1 * frame), atol=1e-4), (frame, risen)
    assert not live or handles.follows(obj, (1.0, 0.0, 0.0))
