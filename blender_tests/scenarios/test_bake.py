# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking to a point cache: what plays, and what moves the handles."""

import re

import bpy
import numpy as np
import pytest
from mathutils import Vector
from support import armatures, bent_limb, handles, installed, libraries, marked_tube, meshes, steps
from support.baking import FRAMES, animated_tube, bake, curves, key_control, played, rest, rows, save

# -- what plays ------------------------------------------------------------------------------------------------------


def test_it_plays_what_was_solved_at_every_frame(saved):
    obj, _control, path = saved
    before = bpy.context.scene.frame_current
    bake()
    assert bpy.context.scene.frame_current == before
    solved = rows(path)
    assert solved.shape == (FRAMES, len(obj.data.vertices), 3)
    times = range(1, FRAMES + 1)
    assert np.array_equal(played(obj, times), solved)
    assert np.ptp(solved, axis=0).max() > 1.0  # it moves
    assert obj.modifiers[0].filepath == "//meanvalue_cache/scene/Tube.pc2"


def swinging_limb():
    """A limb whose end swings: its middle turns more at a time than what the handle asks for."""
    vertices, faces = bent_limb.limb()
    obj = meshes.make_object(vertices.tolist(), faces, "Limb")
    steps.add_handle(obj, "Start", np.flatnonzero(vertices[:, 0] < 0.3).tolist(), pin=True)
    steps.add_handle(obj, "End", np.flatnonzero(vertices[:, 0] > bent_limb.LENGTH - 0.3).tolist(), live=False)
    control, base = bpy.context.object, bpy.context.object.location.copy()
    for frame in range(1, 41):
        swing = np.sin(2 * np.pi * (frame - 1) / 40)
        control.location = base + Vector((-0.6 * abs(swing), 0.1 * swing, 2.0 * swing))
        control.rotation_euler = (0.0, -0.9 * swing, 0.0)
        control.keyframe_insert("location", frame=frame)
        control.keyframe_insert("rotation_euler", frame=frame)
    meshes.activate(obj)
    return obj, float(np.linalg.norm(np.ptp(vertices, axis=0)))


def test_each_frame_is_what_live_shows_whatever_was_shown_before(tmp_path):
    obj, size = swinging_limb()
    save(tmp_path)
    bake()
    solved = rows(tmp_path / "meanvalue_cache" / "scene" / "Limb.pc2")
    assert len(solved) == 40
    bpy.ops.meanvalue.unbake()
    obj.meanvalue.live = True
    for frame in (*range(1, 41, 7), *range(40, 0, -3), 12, 31, 2):
        bpy.context.scene.frame_set(frame)
        bpy.context.view_layer.update()
        off = np.linalg.norm(meshes.seen(obj) - solved[frame - 1], axis=1).max() / size
        assert off < 1e-5, (frame, off)


@pytest.mark.parametrize(("target", "near"), [('POINT_CACHE', 1e-5), ('SHAPE_KEYS', 0.02), ('ARMATURE', 0.1)])
def test_kept_poses_and_other_keys_show_as_they_do_with_live(tmp_path, target, near):
    obj, control = handles.tube()
    handles.move(control, (0.0, 3.0, 1.0))
    assert bpy.ops.meanvalue.keep_pose() == {'FINISHED'}
    driver = steps.add_key(obj, "Grow", rest(obj) * (1.0, 1.0, 1.2)).driver_add("value").driver
    driver.expression = "frame * 0.05" if target != 'ARMATURE' else "0"  # bones bend what such a key has made
    key_control(control)
    save(tmp_path)
    shown = played(obj, range(1, FRAMES + 1))
    again = (bpy.ops.meanvalue.bake, {"target": target})
    for operator, options in (again, again, (bpy.ops.meanvalue.unbake, {})):
        assert operator(**options) == {'FINISHED'}
        assert np.abs(played(obj, range(1, FRAMES + 1)) - shown).max() < near < np.abs(shown - rest(obj)).max() - 3.0


def test_a_snap_is_told_by_bake_and_by_live(tmp_path, capfd):
    """A strut that is squeezed, its ends turned to and fro: it snaps to the other side. Both tell the same frame."""
    obj = meshes.tube(41, 8)
    vertices = rest(obj)
    length, diagonal = np.ptp(vertices[:, 2]), np.linalg.norm(np.ptp(vertices, axis=0))
    is_end = {"Low": vertices[:, 2] < 3.0, "High": vertices[:, 2] > length - 3.0}
    for sign, (name, chosen) in zip((1.0, -1.0), is_end.items(), strict=True):
        meshes.activate(obj)
        control = steps.add_handle(obj, name, np.flatnonzero(chosen).tolist(), live=False)
        control.location.z += 0.1 * sign * length
        for frame, angle in ((1, 0.7), (61, -0.7)):
            control.rotation_euler.y = sign * angle
            control.keyframe_insert("rotation_euler", frame=frame)
    meshes.activate(obj)
    bpy.context.scene.frame_end = 61
    save(tmp_path)
    bake()
    path = tmp_path / "meanvalue_cache" / "scene" / "Tube.pc2"
    solved, snap = rows(path), int(re.search(r"The pose snaps at frame (\d+):", capfd.readouterr().out)[1]) - 1
    bpy.ops.meanvalue.unbake()
    obj.meanvalue.live = True
    for way in (range(1, 62), range(60, 0, -1)):
        told = {}
        for frame in way:
            bpy.context.scene.frame_set(frame)
            bpy.context.view_layer.update()
            said = installed.part("live.roll").follower_of(obj).status(obj)
            told[frame] = re.findall(r"snaps at frame (\d+)", said[0] if said else "")
            if abs(frame - 1 - snap) > 20:
                assert np.linalg.norm(meshes.seen(obj) - solved[frame - 1], axis=1).max() < 1e-3 * diagonal
        assert told[frame] == [str(snap + 1)], told


def test_handles_are_met_exactly_and_pins_do_not_move(saved):
    obj, control, path = saved
    relation = np.linalg.inv(np.array(obj.matrix_world.inverted() @ control.matrix_world))
    bake()
    resting, solved = rest(obj), rows(path)
    for frame in range(1, FRAMES + 1):
        bpy.context.scene.frame_set(frame)
        move = np.array(obj.matrix_world.inverted() @ control.matrix_world) @ relation
        wanted = resting[handles.TOP] @ move[:3, :3].T + move[:3, 3]
        assert np.abs(solved[frame - 1][handles.TOP] - wanted).max() < 2e-5
        assert np.array_equal(solved[frame - 1][handles.BOTTOM], resting[handles.BOTTOM])


def test_the_object_may_move_too(saved):
    obj, _control, path = saved
    bake()
    still = rows(path)
    obj.location = (0.0, 0.0, 0.0)
    obj.keyframe_insert("location", frame=1)
    obj.location = (5.0, 0.0, 2.0)
    obj.keyframe_insert("location", frame=FRAMES)
    bake()
    assert np.abs(rows(path) - still).max() < 1e-4  # its controls are its children


@pytest.mark.parametrize(("options", "times"), [
    ({"samples": 4, "frame_range": 'OWN', "frame_start": 3, "frame_end": 5}, np.arange(3, 5.1, 0.25)),
    ({"frame_range": 'OWN', "frame_start": -4, "frame_end": 2}, range(-4, 3)),
    ({"frame_range": 'OWN', "frame_start": 7, "frame_end": 7}, [7]),
    ({"frame_range": 'SCENE'}, range(1, FRAMES + 1)),
])  # fmt: skip
def test_ranges_and_samples(saved, options, times):
    obj, _control, path = saved
    bake(**options)
    assert len(rows(path)) == len(times)
    assert np.array_equal(played(obj, times), rows(path))


def test_what_is_animated_is_baked_and_no_more(saved):
    obj, control, path = saved
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 250
    bake()
    assert len(rows(path)) == FRAMES
    scene.frame_start = 4
    bake()
    assert len(rows(path)) == FRAMES - 3
    obj.location.x = 2.0
    obj.keyframe_insert("location", frame=20)
    bake()
    assert len(rows(path)) == 17
    curves(control)[0].modifiers.new('CYCLES')  # more than keyframes tell
    bake()
    assert len(rows(path)) == 247


def test_of_a_take_its_frames_are_baked(tmp_path):
    _obj, take = marked_tube.set_up(tmp_path)
    marked_tube.match()
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 250
    bake(path=str(tmp_path / "take.pc2"))
    last = max(curve.range()[1] for marker in take.objects for curve in curves(marker))
    assert len(rows(tmp_path / "take.pc2")) == int(np.ceil(last)) < 100


@pytest.mark.parametrize(("how", "last"), [("goes on", 30), ("rig", 20)])
def test_the_range_has_all_that_moves(tmp_path, how, last):
    obj, control = animated_tube()
    bpy.context.scene.frame_end = 30
    if how == "goes on":
        curves(control)[0].extrapolation = 'LINEAR'
    else:
        rig = armatures.make(Hip=((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
        obj.modifiers.new("Rig", 'ARMATURE').object = rig
        for frame in (1, 20):
            rig.pose.bones["Hip"].keyframe_insert("location", frame=frame)
        meshes.activate(obj)
    bake(path=str(tmp_path / "take.pc2"))
    assert len(rows(tmp_path / "take.pc2")) == last


def test_it_is_above_other_modifiers_and_they_work_on_it(saved):
    obj, _control, path = saved
    subdivision = obj.modifiers.new("Subdivision", 'SUBSURF')
    subdivision.levels = 1
    bake()
    assert [modifier.type for modifier in obj.modifiers] == ['MESH_CACHE', 'SUBSURF']
    bpy.context.scene.frame_set(4)
    assert len(meshes.seen(obj)) > len(obj.data.vertices)
    subdivision.show_viewport = False
    assert np.array_equal(played(obj, [4])[0], rows(path)[3])


def test_it_plays_without_the_addon(saved, tmp_path):
    _obj, _control, path = saved
    bake()
    solved = rows(path)
    save(tmp_path)
    installed.disable()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))
    assert not hasattr(bpy.types.Object, "meanvalue")
    assert np.array_equal(played(bpy.data.objects["Tube"], range(1, FRAMES + 1)), solved)


def test_it_links(saved, tmp_path):
    _obj, _control, path = saved
    bake()
    save(tmp_path)
    solved = rows(path)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    (obj,) = libraries.load(tmp_path / "scene.blend", "objects", ["Tube"], link=True)
    assert np.array_equal(played(obj, [1, 6, FRAMES]), solved[[0, 5, FRAMES - 1]])


# -- what moves the handles ------------------------------------------------------------------------------------------


def baked_top(obj, path, frames=FRAMES):
    """(f, 3): the middle of Top at each frame, and that the modifier shows it."""
    bake(frame_range='OWN', frame_start=1, frame_end=frames)
    solved = rows(path)
    assert np.array_equal(played(obj, range(1, frames + 1)), solved)
    return solved[:, handles.TOP].mean(axis=1) - rest(obj)[handles.TOP].mean(axis=0)


@pytest.mark.parametrize("how", ["constraint", "driver", "bone"])
def test_what_moves_a_control_without_keyframes(tmp_path, how):
    obj, control = handles.tube(live=False)
    if how == "driver":
        control.driver_add("location", 0).driver.expression = f"{control.location.x} + 0.1 * (frame - 1)"
    elif how == "bone":
        handle, armature = obj.meanvalue.handles["Top"], armatures.make(Hand=((0.0, 0.0, 9.0), (0.0, 0.0, 10.0)))
        handle.control, handle.bone = armature, "Hand"
        bpy.data.objects.remove(control)
        handles.update()
        key_control(armature.pose.bones["Hand"])
        bpy.context.scene.frame_set(1)
    else:
        leader = meshes.new_object("Leader")
        leader.location = control.matrix_world.translation
        control.constraints.new('COPY_LOCATION').target = leader
        handles.update()
        key_control(leader)
    meshes.activate(obj)
    save(tmp_path)
    moved = baked_top(obj, tmp_path / "meanvalue_cache" / "scene" / "Tube.pc2")
    assert np.ptp(moved[:, 0]) >= 1.0 and np.abs(moved[0]).max() < 1e-4


def test_physics_is_gone_through_frame_by_frame(tmp_path):
    obj, control = handles.tube(live=False)
    bpy.ops.mesh.primitive_cube_add(location=control.matrix_world.translation)
    cube = bpy.context.object
    bpy.ops.rigidbody.object_add()
    cube.rigid_body.collision_collections[0] = True
    handles.update()
    handle = obj.meanvalue.handles["Top"]
    handle.control = cube
    meshes.activate(obj)
    save(tmp_path)
    moved = baked_top(obj, tmp_path / "meanvalue_cache" / "scene" / "Tube.pc2")
    fall = -moved[:, 2]
    assert fall[-1] > 0.2
    assert (np.diff(fall)[1:] > 0).all()


def test_influence_frees_a_soft_handle(tmp_path):
    obj, control = animated_tube()
    obj.meanvalue.handles["Top"].is_soft = True
    obj.meanvalue.handles["Top"].strength = 0.9
    save(tmp_path)
    path = tmp_path / "meanvalue_cache" / "scene" / "Tube.pc2"
    bake()
    pulled = rows(path)
    control.meanvalue.influence = 0.0
    control.keyframe_insert("meanvalue.influence", frame=1)
    control.keyframe_insert("meanvalue.influence", frame=5)
    control.meanvalue.influence = 1.0
    control.keyframe_insert("meanvalue.influence", frame=6)
    bake()
    freed = rows(path)
    resting = rest(obj)
    assert np.abs(freed[:5] - resting).max() < 1e-2  # nothing pulls: it stays at rest
    assert np.abs(pulled[4] - resting).max() > 0.5
    assert np.abs(freed[-1] - pulled[-1]).max() < 2e-2


@pytest.mark.parametrize("how", ["eye", "eye of the collection", "viewport", "excluded", "collection"])
def test_a_control_that_is_disabled_does_not_move_and_is_told(saved, how):
    """Blender evaluates what is hidden by the eye, and leaves what is disabled where it is."""
    _obj, control, path = saved
    hidden = bpy.data.collections.new("Hidden")
    bpy.context.scene.collection.children.link(hidden)
    control.users_collection[0].objects.unlink(control)
    hidden.objects.link(control)
    layer = bpy.context.view_layer.layer_collection.children["Hidden"]
    control.hide_set(how == "eye")
    control.hide_viewport = how == "viewport"
    layer.hide_viewport = how == "eye of the collection"
    layer.exclude = how == "excluded"
    hidden.hide_viewport = how == "collection"
    if how.startswith("eye"):
        bake()
        assert np.ptp(rows(path)[:, handles.TOP], axis=0).max() > 1.0
        return
    with steps.refused(f"'{control.name}'"):
        bpy.ops.meanvalue.bake()
    assert not path.exists()
