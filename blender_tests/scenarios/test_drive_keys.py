# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles that drive the shape keys that a mesh has, in place of a shape of their own."""

import bpy
import numpy as np
import pytest
from support import halves, meshes, steps
from support.interface import interface, is_settled

CORNERS = [0, 8, 72, 80]
LEFT, RIGHT = [38, 39, 47, 48], [41, 42, 50, 51]


def add_key(obj, name, center, offset, relative="Basis"):
    """A key that moves what is around a vertex by `offset`, (3,)."""
    rest = steps.key_positions(obj, "Basis").astype(float)
    near = np.exp(-((rest - rest[center]) ** 2).sum(axis=1) / 4.0)[:, None]
    return steps.add_key(obj, name, steps.key_positions(obj, relative) + near * offset, relative)


@pytest.fixture
def face():
    """(object, control of the left handle): two handles, pinned corners, four keys; Live drives them."""
    obj = meshes.grid(9, 9)
    obj.shape_key_add(name="Basis")
    add_key(obj, "Up L", 39, (0.0, 0.0, 1.0))
    add_key(obj, "Up R", 41, (0.0, 0.0, 1.0))
    add_key(obj, "Side", 39, (0.5, 0.0, 0.0)).slider_min = -1.0
    add_key(obj, "Muted", 39, (0.0, 0.0, 2.0)).mute = True
    steps.list_anchors(obj, Corners=CORNERS)
    obj.meanvalue.drive = 'SHAPE_KEYS'
    steps.add_handle(obj, "Right", RIGHT)
    meshes.activate(obj)
    control = steps.add_handle(obj, "Left", LEFT)
    meshes.activate(obj)
    bpy.context.view_layer.update()
    return obj, control


def values(obj):
    return {key.name: key.value for key in obj.data.shape_keys.key_blocks[1:]}


def move(control, **channels):
    for name, value in channels.items():
        setattr(control.location, name, getattr(control.location, name) + value)
    bpy.context.view_layer.update()


def test_sliders_follow_within_their_ranges(face):
    obj, control = face
    assert max(map(abs, values(obj).values())) < 1e-3
    before = meshes.seen(obj)[LEFT].mean(axis=0)
    move(control, z=0.4, x=-0.2)
    found = values(obj)
    assert 0.25 < found["Up L"] < 0.7
    assert -1.0 < found["Side"] < -0.1
    assert found["Muted"] == 0.0
    moved = meshes.seen(obj)[LEFT].mean(axis=0) - before
    np.testing.assert_allclose(moved, (-0.2, 0.0, 0.4), atol=0.12)
    assert obj.meanvalue.result_key not in obj.data.shape_keys.key_blocks
    move(control, z=9.0)
    assert values(obj)["Up L"] == 1.0


def test_a_slow_drag_changes_values_steadily_and_ends_where_a_jump_does(face):
    obj, control = face
    start = control.location.copy()
    rows = []
    with interface() as timers:
        for _ in range(40):
            move(control, z=0.02, x=0.01)
            timers.run(0.05)
            rows.append(list(values(obj).values()))
        assert is_settled(obj)
    steps_of_values = np.abs(np.diff(rows, axis=0))
    assert steps_of_values.max() < 3.0 * steps_of_values.max(axis=1).mean()
    end = control.location.copy()
    control.location = start
    bpy.context.view_layer.update()
    assert max(map(abs, values(obj).values())) < 1e-3
    control.location = end
    bpy.context.view_layer.update()
    np.testing.assert_allclose(list(values(obj).values()), rows[-1], atol=1e-5)


def test_keyframes_go_on_the_values(face, part):
    obj, control = face
    move(control, z=0.4)
    steps.run(obj, "keyframe_handles")
    keys = obj.data.shape_keys
    frames, keyed = part("scene.actions").read_keys(keys, 'key_blocks["Up L"].value')
    assert frames.tolist() == [1.0]
    assert keyed[0] == pytest.approx(values(obj)["Up L"])
    assert control.animation_data is None


def test_shape_and_shape_keys_take_turns(face):
    obj, control = face
    obj.meanvalue.drive = 'SHAPE'
    for key in obj.data.shape_keys.key_blocks[1:]:
        key.value = 0.0
    move(control, z=0.4)
    result = obj.data.shape_keys.key_blocks[obj.meanvalue.result_key]
    assert not result.mute
    posed = meshes.seen(obj)
    obj.meanvalue.drive = 'SHAPE_KEYS'
    bpy.context.view_layer.update()
    assert result.mute
    assert not bpy.ops.meanvalue.keep_pose.poll() and not bpy.ops.meanvalue.apply_pose.poll()
    assert values(obj)["Up L"] > 0.25
    for key in obj.data.shape_keys.key_blocks[1:]:
        if key != result:
            key.value = 0.0
    obj.meanvalue.drive = 'SHAPE'
    bpy.context.view_layer.update()
    np.testing.assert_allclose(meshes.seen(obj), posed, atol=1e-3)


def test_a_new_handle_starts_where_the_keys_have_the_mesh(face):
    obj, control = face
    move(control, z=0.4)
    before = values(obj)
    meshes.activate(obj)
    steps.add_handle(obj, "Middle", [40])
    bpy.context.view_layer.update()
    np.testing.assert_allclose(list(values(obj).values()), list(before.values()), atol=0.03)


def test_grab_drags_the_sliders_and_nothing_is_lost_on_the_way_back(face):
    obj, _ = face
    assert bpy.ops.meanvalue.grab(vertex=39, offset=(0.0, 0.0, 0.5)) == {'FINISHED'}
    bpy.context.view_layer.update()
    assert 0.3 < values(obj)["Up L"] < 0.8


def test_a_handle_s_image_counts_as_a_handle_at_its_place():
    found = []
    for axis in ('X', 'NONE'):
        obj, control = halves.whole(live=False, name=axis)
        rest = np.array([tuple(vertex.co) for vertex in obj.data.vertices])
        steps.add_key(obj, "Up", np.add(rest, (0.0, 0.0, 1.0)))
        obj.meanvalue.symmetric, obj.meanvalue.drive = axis, 'SHAPE_KEYS'
        if axis == 'NONE':
            move(steps.add_handle(obj, "Other", np.flatnonzero(rest[:, 0] < -0.7).tolist()), z=1.0)
        obj.meanvalue.live = True
        move(control, z=1.0)
        found.append(values(obj)["Up"])
    assert found[0] == pytest.approx(found[1], abs=0.01) and 0.6 < found[0] < 0.7  # two of three ask for it


def test_a_corrective_has_what_the_sliders_do_not_reach(face, capfd):
    obj, control = face
    group, before = obj.vertex_groups["Left"], values(obj)
    with steps.refused("nothing left for a corrective"):
        bpy.ops.meanvalue.add_corrective()
    move(control, z=0.4, y=0.6)
    control.rotation_euler.z = 0.5
    bpy.context.view_layer.update()
    wanted, driven = np.array(control.matrix_world.translation), values(obj)
    assert np.linalg.norm(meshes.seen(obj)[LEFT].mean(axis=0) - wanted) > 0.4
    for _ in range(2):  # the second time changes nothing
        assert bpy.ops.meanvalue.add_corrective() == {'FINISHED'}
        bpy.context.view_layer.update()
        np.testing.assert_allclose(meshes.seen(obj)[LEFT].mean(axis=0), wanted, atol=1e-3)
        np.testing.assert_allclose(meshes.seen(obj)[CORNERS], steps.key_positions(obj, "Basis")[CORNERS], atol=1e-3)
        found = values(obj)
        assert found.pop("Corrective") == 1.0
        np.testing.assert_allclose(list(found.values()), list(driven.values()), atol=1e-5)
    assert group.name in obj.vertex_groups and before.keys() == driven.keys()
    move(control, z=0.3)
    assert values(obj)["Up L"] > driven["Up L"] + 0.1 and values(obj)["Corrective"] == 1.0
    obj.meanvalue.drive = 'SHAPE'
    assert not bpy.ops.meanvalue.add_corrective.poll()
    move(control, z=0.3)
    steps.run(obj, "apply_pose")
    assert "5 shape keys carried along" in capfd.readouterr().out  # the corrective is one


def test_a_key_of_the_artist_s_own_that_is_called_corrective_is_left_alone(face):
    obj, control = face
    own = obj.shape_key_add(name="Corrective", from_mix=False)
    own.data[39].co.z += 0.1
    before = steps.key_positions(obj, "Corrective")
    move(control, z=0.4, y=0.6)
    assert bpy.ops.meanvalue.add_corrective() == {'FINISHED'}
    np.testing.assert_array_equal(steps.key_positions(obj, "Corrective"), before)
    assert values(obj)["Corrective.001"] == 1.0
    obj.data.shape_keys.key_blocks["Corrective.001"].name = "Lid"
    assert bpy.ops.meanvalue.add_corrective() == {'FINISHED'}
    assert sum(key.name in {"Lid", "Corrective.001"} for key in obj.data.shape_keys.key_blocks) == 1


def test_undo_and_reloading_end_with_the_same_values(face, tmp_path):
    obj, control = face
    name = obj.name
    move(control, z=0.4)
    before = values(obj)
    obj = steps.reopened(obj, tmp_path / "driven.blend")
    bpy.context.view_layer.update()
    np.testing.assert_allclose(list(values(obj).values()), list(before.values()), atol=1e-5)
    bpy.ops.ed.undo_push(message="Before")
    move(obj.meanvalue.handles["Left"].control, z=0.3)
    assert values(obj)["Up L"] > before["Up L"] + 0.1
    bpy.ops.ed.undo_push(message="After")
    bpy.ops.ed.undo()
    obj = bpy.data.objects[name]
    bpy.context.view_layer.update()
    np.testing.assert_allclose(list(values(obj).values()), list(before.values()), atol=1e-5)


def test_handles_pose_behind_a_rig_that_moves(face):
    obj, control = face
    obj.modifiers.new("Cast", 'CAST').factor = 0.0
    lattice = meshes.new_object("Lattice", bpy.data.lattices.new("Lattice"))
    lattice.scale = (30.0, 30.0, 30.0)
    obj.modifiers.new("Lattice", 'LATTICE').object = lattice
    bpy.context.view_layer.update()
    move(control, z=0.4)
    assert 0.25 < values(obj)["Up L"] < 0.6


def test_what_is_wrong_is_said_and_nothing_changes(face, status):
    obj, control = face
    for key in obj.data.shape_keys.key_blocks[1:]:
        key.mute = True
    move(control, z=0.4)
    assert status(obj)[1]
    assert not any(values(obj).values())
    for key in obj.data.shape_keys.key_blocks[1:]:
        key.mute = False
    obj.show_only_shape_key = True
    bpy.context.view_layer.update()
    assert "is pinned" in status(obj)[0]
