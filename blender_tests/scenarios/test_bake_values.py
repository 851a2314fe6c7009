# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake Shape Key Values: from animated handles and from markers to F-curves of the keys that the mesh has."""

import bpy
import numpy as np
import pytest
from support import armatures, faces, marked_face, meshes, steps, take_files

FRAMES = np.arange(1, 61)
HEAD = {"source": 'MARKERS'}


@pytest.fixture
def face():
    bpy.context.scene.frame_end = 60
    return marked_face.make()


def bake(**options):
    return bpy.ops.meanvalue.bake_values(**options)


def is_near(obj, truth, error=0.05):
    """Whether 95 % of the values are within `error` of the truth."""
    return np.quantile(np.abs(marked_face.keyed(obj, FRAMES[: len(truth)]) - truth), 0.95) < error


def assert_seen(face, truth, carried=None):
    """With its values, and where the captured head was; carried: 4 x 4, by bones that are posed besides."""
    for frame in (1, 16, 47):
        bpy.context.scene.frame_set(frame)
        world = np.array(face.evaluated_get(bpy.context.evaluated_depsgraph_get()).matrix_world)
        seen = meshes.seen(face) @ world[:3, :3].T + world[:3, 3]
        turn = (np.eye(4) if carried is None else carried) @ faces.head_motion(60)[frame - 1]
        wanted = faces.mixed(truth[frame - 1]) @ turn[:3, :3].T + turn[:3, 3]
        assert np.abs(seen - wanted).max() < 0.002, (face.rotation_mode, frame)


def with_take(obj, tmp_path, picked=marked_face.PICKED, **damage):
    truth = faces.values()
    vertices = marked_face.captured(tmp_path / "face.trc", obj, truth, **damage)
    marked_face.pick(vertices, picked)
    return truth


def with_handles(obj, truth, count=24):
    """Controls that go where vertices of the face go."""
    vertices = faces.marked(count)
    moved = np.array([faces.mixed(of_frame)[vertices] for of_frame in truth]) - faces.rest()[0][vertices]
    for number, vertex in enumerate(vertices.tolist()):
        meshes.activate(obj)
        control = steps.add_handle(obj, f"H{number}", [vertex], live=False)
        start = np.array(control.location)
        for frame, offset in zip(FRAMES, moved[:, number], strict=False):
            control.location = start + offset
            control.keyframe_insert("location", frame=int(frame))
    meshes.activate(obj)


def test_markers_with_noise_and_gaps_give_the_values_back(face, tmp_path):
    truth = with_take(face, tmp_path, noise=0.0002, gaps=0.08)
    assert bake(**HEAD) == {'FINISHED'}
    assert is_near(face, truth)
    assert np.abs(marked_face.keyed(face, FRAMES) - truth).mean() < 0.015


def test_the_head_s_motion_goes_onto_the_object_or_is_dropped(face, tmp_path):
    truth = with_take(face, tmp_path)
    assert bake(head_motion='DROPPED', **HEAD) == {'FINISHED'}
    assert face.animation_data is None
    assert is_near(face, truth, 0.02)
    for mode in ('QUATERNION', 'XYZ', 'AXIS_ANGLE'):
        bpy.context.scene.frame_set(1)
        face.rotation_mode = mode
        assert bake(replace=True, tolerance=0.0, **HEAD) == {'FINISHED'}
        assert_seen(face, truth)
        assert np.allclose(face.scale, 1.0, atol=1e-6)


@pytest.mark.parametrize("kind", ["parented", "skinned", "skinned and posed"])
def test_the_head_s_motion_goes_onto_a_bone(face, tmp_path, kind):
    rig = armatures.make(Neck=((0.0, 0.0, -0.3), (0.0, 0.0, -0.1)), Head=((0.0, 0.0, -0.1), (0.0, 0.1, 0.1), "Neck"))
    rig.location, rig.rotation_euler = (0.3, -0.2, 0.1), (0.2, 0.4, -0.3)
    bpy.context.view_layer.update()
    carried = np.eye(4)
    if kind != "parented":
        steps.add_weights(face, "Head", np.ones(len(face.data.vertices)))
        face.modifiers.new("Armature", 'ARMATURE').object = rig
    if kind == "skinned and posed":
        for name in ("Neck", "Head"):
            rig.pose.bones[name].rotation_mode = 'XYZ'
            rig.pose.bones[name].rotation_euler = (0.3, -0.2, 0.1)
        bpy.context.view_layer.update()
        bone = rig.pose.bones["Head"]
        carried = np.array(rig.matrix_world @ bone.matrix @ (rig.matrix_world @ bone.bone.matrix_local).inverted())
    if kind == "parented":
        world = face.matrix_world.copy()
        face.parent, face.parent_type, face.parent_bone = rig, 'BONE', "Head"
        face.matrix_world = world
    meshes.activate(face)
    truth = with_take(face, tmp_path)
    with pytest.raises(RuntimeError, match="has no bone 'Jaw'"):
        bake(head_motion='BONE', bone="Jaw", **HEAD)
    for mode in ('QUATERNION', 'XYZ', 'AXIS_ANGLE'):
        bpy.context.scene.frame_set(1)
        rig.pose.bones["Head"].rotation_mode = mode
        assert bake(head_motion='BONE', bone="Head", replace=True, tolerance=0.0, **HEAD) == {'FINISHED'}
        assert face.animation_data is None
        assert_seen(face, truth, carried)
    face.data.shape_keys.animation_data_clear()
    with pytest.raises(RuntimeError, match="of 'Head' is animated already"):
        bake(head_motion='BONE', bone="Head", **HEAD)


def test_markers_that_tell_nothing_are_left_out(face, tmp_path):
    wand = np.array([0.3, 0.0, 0.0]) + 0.1 * np.sin(np.arange(60) / 9)[:, None]
    others = {f"Wand{k}": wand + 0.03 * np.array([np.sin(k), np.cos(k), k / 20]) for k in range(20)}
    others["Stuck"] = np.tile([0.0, -0.1, 0.0], (60, 1))
    truth = with_take(face, tmp_path, others=others)
    assert bake(**HEAD) == {'FINISHED'}
    assert is_near(face, truth, 0.02)


def test_a_marker_that_slips_is_not_followed(face, tmp_path):
    slips = faces.recorded(faces.values(), faces.marked())[:, 5].copy()
    slips[30:40] += [0.03, -0.02, 0.0]
    truth = with_take(face, tmp_path, noise=0.0001, others={"Slips": slips})
    assert bake(**HEAD) == {'FINISHED'}
    assert is_near(face, truth)


@pytest.mark.parametrize("picked", [0, 2])
def test_fewer_than_three_pairs_say_how_to_pick_them(face, tmp_path, picked):
    truth = faces.values()
    vertices = marked_face.captured(tmp_path / "face.trc", face, truth)
    if picked:
        marked_face.pick(vertices, picked)
    with pytest.raises(RuntimeError, match=r"at least 3 markers .* press Pick Point and click its point"):
        bake(**HEAD)
    assert face.data.shape_keys.animation_data is None and face.animation_data is None


def test_animated_handles_give_the_values_back(face):
    truth = faces.values()
    with_handles(face, truth)
    face.meanvalue.live = True
    assert bake() == {'FINISHED'}
    assert is_near(face, truth, 0.03)
    assert face.animation_data is None
    assert not face.meanvalue.live
    bpy.context.scene.frame_set(24)
    assert np.abs(meshes.seen(face) - faces.mixed(truth[23])).max() < 0.001


def test_a_handle_without_influence_is_a_gap(face):
    truth = faces.values()
    with_handles(face, truth)
    handle = face.meanvalue.handles["H3"]
    handle.is_soft = True
    handle.control.location = (9.0, 9.0, 9.0)
    handle.control.animation_data_clear()
    handle.control.meanvalue.influence = 0.0
    assert bake() == {'FINISHED'}
    assert is_near(face, truth, 0.05)


def test_two_handles_will_do_and_hold_their_mirror_images(face):
    """Of a symmetric face one side is held, by fewer points than a shape of its own needs."""
    keys, names = face.data.shape_keys.key_blocks, list(faces.KEYS)
    for key in keys[1:]:
        key.mute = key.name not in {"browUp_L", "browUp_R"}
    left, right = (names.index(f"browUp_{side}") for side in "LR")
    offset = np.linalg.norm(steps.key_positions(face, "browUp_L") - faces.rest()[0], axis=1)
    vertex = int(offset.argmax())
    meshes.activate(face)
    control = steps.add_handle(face, "Brow", [vertex], live=False)
    moved = steps.key_positions(face, "browUp_L")[vertex] - faces.rest()[0][vertex]
    start = np.array(control.location)
    for frame, share in ((1, 0.0), (30, 0.8), (60, 0.2)):
        control.location = start + share * moved
        control.keyframe_insert("location", frame=frame)
    meshes.activate(face)
    face.meanvalue.symmetric = 'X'
    assert bake() == {'FINISHED'}
    found = marked_face.keyed(face, [1, 30, 60])
    np.testing.assert_allclose(found[:, left], (0.0, 0.8, 0.2), atol=0.05)
    np.testing.assert_allclose(found[:, right], found[:, left], atol=0.05)


def test_range_and_tolerance(face):
    with_handles(face, faces.values())
    assert bake(frame_range='OWN', frame_start=10, frame_end=30, tolerance=0.0) == {'FINISHED'}
    path = 'key_blocks["jawOpen"].value'
    every = take_files.keys(face.data.shape_keys, path)
    assert np.array_equal(every[:, 0], np.arange(10, 31))
    assert bake(frame_range='OWN', frame_start=10, frame_end=30, tolerance=0.02, replace=True) == {'FINISHED'}
    few = take_files.keys(face.data.shape_keys, path)
    assert 2 <= len(few) < 15
    assert np.abs(np.interp(every[:, 0], few[:, 0], few[:, 1]) - every[:, 1]).max() < 0.0201


def test_locked_driven_muted_and_unseen_keys_are_left_alone_and_named(face, capfd):
    keys = face.data.shape_keys.key_blocks
    keys["mouthPucker"].driver_add("value")
    keys["browUp_L"].mute = True
    back = face.shape_key_add(name="Nape", from_mix=False)
    back.value = 0.0
    points = faces.rest()[0]
    nape = int(points[:, 1].argmax())
    back.data[nape].co = points[nape] + [0.0, 0.01, 0.0]
    truth = faces.values() * [name not in {"mouthPucker", "browUp_L"} for name in faces.KEYS]
    with_handles(face, truth)
    assert bake() == {'FINISHED'}
    said = capfd.readouterr().out
    for words in ("'browUp_L' (muted)", "'mouthPucker' (moved by a driver)", "do not see 'Nape'"):
        assert words in said, said
    for name in ("mouthPucker", "browUp_L", "Nape"):
        assert len(take_files.keys(face.data.shape_keys, f'key_blocks["{name}"].value')) == 0


def test_what_is_animated_already_is_kept_unless_replaced(face):
    with_handles(face, faces.values())
    key = face.data.shape_keys.key_blocks["jawOpen"]
    key.keyframe_insert("value", frame=3)
    with pytest.raises(RuntimeError, match="'jawOpen' is animated already"):
        bake()
    key.keyframe_delete("value", frame=3)
    face.keyframe_insert("location", frame=1)
    with pytest.raises(RuntimeError, match="location of 'Face' is animated already"):
        bake(head_motion='OBJECT')
    face.animation_data_clear()
    face.scale = (1.0, 1.0, 2.0)
    with pytest.raises(RuntimeError, match="scaled unevenly"):
        bake(head_motion='OBJECT')
    assert bake() == {'FINISHED'}


def test_one_undo_takes_it_back(face):
    with_handles(face, faces.values(20))
    bpy.ops.ed.undo_push(message="before")
    assert bake(head_motion='OBJECT') == {'FINISHED'}
    bpy.ops.ed.undo_push(message="after")
    bpy.ops.ed.undo()
    obj = bpy.data.objects["Face"]
    assert obj.data.shape_keys.animation_data is None or obj.data.shape_keys.animation_data.action is None
    assert obj.animation_data is None or obj.animation_data.action is None
