# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking to a point cache: what moves the handles, what plays, what is kept and what is refused."""

import json
import pathlib
import types

import bpy
import numpy as np
import pytest
from support import handles, meshes, steps
from support.baking import FRAMES, animated_tube, bake, curves, key_control, played, rest, save, shown
from support.snapshot import assert_same, snapshot


@pytest.fixture
def rows(part):
    """rows(path): (f, n, 3) of a point cache."""
    cache = part("core.point_cache")
    return lambda path: cache.read_rows(path, 0, cache.read_header(path).samples)


@pytest.fixture
def saved(tmp_path):
    """(object, control, path of its cache) of an animated tube in a saved file."""
    obj, control = animated_tube()
    save(tmp_path)
    return obj, control, tmp_path / "meanvalue_cache" / "Tube.pc2"


# -- what plays ------------------------------------------------------------------------------------------------------


def test_it_plays_what_was_solved_at_every_frame(saved, rows):
    obj, _control, path = saved
    before = bpy.context.scene.frame_current
    bake()
    assert bpy.context.scene.frame_current == before
    solved = rows(path)
    assert solved.shape == (FRAMES, len(obj.data.vertices), 3)
    times = range(1, FRAMES + 1)
    assert np.array_equal(played(obj, times), solved)
    assert np.ptp(solved, axis=0).max() > 1.0  # it moves
    assert obj.modifiers[0].filepath == "//meanvalue_cache/Tube.pc2"


def test_each_frame_is_what_solve_gives_to_the_tolerance(saved, rows):
    obj, _control, path = saved
    bake()
    solved = rows(path)
    bpy.ops.meanvalue.unbake()
    for frame in (1, 5, FRAMES):
        bpy.context.scene.frame_set(frame)
        steps.solve()
        assert np.abs(handles.shown(obj) - solved[frame - 1]).max() < 2e-2, frame


def test_handles_are_met_exactly_and_pins_do_not_move(saved, rows):
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


def test_the_object_may_move_too(saved, rows):
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
    ({"step": 3}, [1, 4, 7, 10]),
    ({"samples": 4, "frame_range": 'OWN', "frame_start": 3, "frame_end": 5}, np.arange(3, 5.1, 0.25)),
    ({"frame_range": 'OWN', "frame_start": -4, "frame_end": 2}, range(-4, 3)),
    ({"frame_range": 'OWN', "frame_start": 7, "frame_end": 7}, [7]),
])  # fmt: skip
def test_ranges_steps_and_samples(saved, rows, options, times):
    obj, _control, path = saved
    bake(**options)
    assert len(rows(path)) == len(times)
    assert np.array_equal(played(obj, times), rows(path))


def test_between_samples_it_is_blended(saved, rows):
    obj, _control, path = saved
    bake(step=2)
    solved = rows(path)
    assert np.abs(played(obj, [2, 4]) - 0.5 * (solved[:2] + solved[1:3])).max() < 1e-5


def test_it_is_above_other_modifiers_and_they_work_on_it(saved, rows):
    obj, _control, path = saved
    subdivision = obj.modifiers.new("Subdivision", 'SUBSURF')
    subdivision.levels = 1
    bake()
    assert [modifier.type for modifier in obj.modifiers] == ['MESH_CACHE', 'SUBSURF']
    bpy.context.scene.frame_set(4)
    assert len(shown(obj)) > len(obj.data.vertices)
    subdivision.show_viewport = False
    assert np.array_equal(played(obj, [4])[0], rows(path)[3])


def test_it_plays_and_renders_without_the_addon(saved, rows, tmp_path):
    _obj, _control, path = saved
    bake()
    solved = rows(path)
    save(tmp_path)
    bpy.ops.preferences.addon_disable(module="meanvalue_deform")
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))
    assert not hasattr(bpy.types.Object, "meanvalue")
    assert np.array_equal(played(bpy.data.objects["Tube"], range(1, FRAMES + 1)), solved)
    pictures = [rendered(frame, tmp_path) for frame in (1, 1, 4)]
    assert np.array_equal(pictures[0], pictures[1])
    assert np.abs(pictures[0] - pictures[2]).max() > 0.1


def rendered(frame, tmp_path):
    """Pixels of a small picture of the frame."""
    scene = bpy.context.scene
    if scene.camera is None:
        scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        scene.collection.objects.link(scene.camera)
        scene.camera.location, scene.camera.rotation_euler = (0.0, -30.0, 5.0), (np.pi / 2, 0.0, 0.0)
        scene.world = bpy.data.worlds.new("Grey")
    scene.render.engine = 'CYCLES'
    scene.cycles.samples, scene.cycles.use_denoising = 1, False
    scene.render.resolution_x = scene.render.resolution_y = 32
    scene.render.film_transparent = True
    scene.render.filepath = str(tmp_path / f"frame_{frame}.png")
    scene.frame_set(frame)
    bpy.ops.render.render(write_still=True)
    picture = bpy.data.images.load(scene.render.filepath)
    return np.array(picture.pixels).reshape(32, 32, 4)[..., 3]


def test_it_links(saved, rows, tmp_path):
    _obj, _control, path = saved
    bake()
    save(tmp_path)
    solved = rows(path)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(str(tmp_path / "scene.blend"), link=True) as (_there, here):
        here.objects = ["Tube"]
    bpy.context.scene.collection.objects.link(here.objects[0])
    assert np.array_equal(played(here.objects[0], [1, 6, FRAMES]), solved[[0, 5, FRAMES - 1]])


# -- what moves the handles ------------------------------------------------------------------------------------------


def baked_top(obj, path, rows, frames=FRAMES):
    """(f, 3): the middle of Top at each frame, and that the modifier shows it."""
    bake(frame_range='OWN', frame_start=1, frame_end=frames)
    solved = rows(path)
    assert np.array_equal(played(obj, range(1, frames + 1)), solved)
    return solved[:, handles.TOP].mean(axis=1) - rest(obj)[handles.TOP].mean(axis=0)


def test_a_constraint(rows, tmp_path):
    obj, control = handles.tube(live=False)
    leader = bpy.data.objects.new("Leader", None)
    bpy.context.collection.objects.link(leader)
    leader.location = control.matrix_world.translation
    handles.update()
    control.constraints.new('COPY_LOCATION').target = leader
    handles.update()
    key_control(leader)
    meshes.activate(obj)
    save(tmp_path)
    moved = baked_top(obj, tmp_path / "meanvalue_cache" / "Tube.pc2", rows)
    assert np.ptp(moved[:, 0]) > 1.0


def test_a_driver(rows, tmp_path):
    obj, control = handles.tube(live=False)
    height = control.location.x
    control.driver_add("location", 0).driver.expression = f"{height} + 0.1 * (frame - 1)"
    meshes.activate(obj)
    save(tmp_path)
    moved = baked_top(obj, tmp_path / "meanvalue_cache" / "Tube.pc2", rows)
    assert np.allclose(moved[:, 0], 0.1 * np.arange(FRAMES), atol=1e-4)


def test_a_bone(rows, tmp_path):
    obj, control = handles.tube(live=False)
    armature = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
    bpy.context.collection.objects.link(armature)
    meshes.activate(armature)
    bpy.ops.object.mode_set(mode='EDIT')
    bone = armature.data.edit_bones.new("Hand")
    bone.head, bone.tail = (0.0, 0.0, 9.0), (0.0, 0.0, 10.0)
    bpy.ops.object.mode_set(mode='OBJECT')
    line = obj.meanvalue.anchor_groups["Top"]
    line.control = armature
    line.bone = "Hand"
    bpy.data.objects.remove(control)
    handles.update()
    pose = armature.pose.bones["Hand"]
    for frame, x in ((1, 0.0), (FRAMES, 2.0)):
        pose.location = (x, 0.0, 0.0)
        pose.keyframe_insert("location", frame=frame)
    meshes.activate(obj)
    save(tmp_path)
    bpy.context.scene.frame_set(1)
    moved = baked_top(obj, tmp_path / "meanvalue_cache" / "Tube.pc2", rows)
    assert moved[0] == pytest.approx([0, 0, 0], abs=1e-4)
    assert np.linalg.norm(moved[-1]) == pytest.approx(2.0, abs=1e-3)


def test_physics_is_gone_through_frame_by_frame(rows, tmp_path):
    obj, control = handles.tube(live=False)
    bpy.ops.mesh.primitive_cube_add(location=control.matrix_world.translation)
    cube = bpy.context.object
    bpy.ops.rigidbody.object_add()
    cube.rigid_body.collision_collections[0] = True
    handles.update()
    line = obj.meanvalue.anchor_groups["Top"]
    line.control = cube
    meshes.activate(obj)
    save(tmp_path)
    moved = baked_top(obj, tmp_path / "meanvalue_cache" / "Tube.pc2", rows)
    fall = -moved[:, 2]
    assert fall[-1] > 0.2
    assert (np.diff(fall)[1:] > 0).all()


def test_influence_frees_a_soft_handle(rows, tmp_path):
    obj, control = animated_tube()
    obj.meanvalue.anchor_groups["Top"].is_soft = True
    obj.meanvalue.anchor_groups["Top"].strength = 0.9
    save(tmp_path)
    path = tmp_path / "meanvalue_cache" / "Tube.pc2"
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


def test_a_handle_in_a_shape_key_stands_still_and_is_told(saved, rows, capfd):
    obj, _control, path = saved
    bpy.ops.meanvalue.add_pose_key()
    middle = range(handles.RINGS // 2 * handles.SEGMENTS, (handles.RINGS // 2 + 1) * handles.SEGMENTS)
    steps.list_anchors(obj, Middle=middle)
    steps.move(obj, middle, (0.0, 0.3, 0.0))
    obj.active_shape_key.value = 0.0
    obj.active_shape_key.keyframe_insert("value", frame=1)
    bake()
    wanted = rest(obj)[middle] + np.float32((0.0, 0.3, 0.0))
    assert np.abs(rows(path)[:, middle] - wanted).max() < 1e-5
    assert "What follows a shape key stands still: Middle as in 'Pose'" in capfd.readouterr().out


@pytest.mark.parametrize("how", ["eye", "eye of the collection", "viewport", "excluded", "collection"])
def test_a_control_that_is_disabled_does_not_move_and_is_told(saved, rows, how):
    """Blender evaluates what is hidden by the eye, and leaves what is disabled where it is."""
    _obj, control, path = saved
    hidden = bpy.data.collections.new("Hidden")
    bpy.context.scene.collection.children.link(hidden)
    bpy.context.scene.collection.objects.unlink(control)
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
    with steps.refused(f"'{control.name}' is disabled in viewports", "hide it by the eye"):
        bpy.ops.meanvalue.bake()
    assert not path.exists()


# -- again, and back -------------------------------------------------------------------------------------------------


def solved_rows(monkeypatch, part):
    """A list that gets (begin, end) of everything that is solved from now on."""
    solving = part("bake.solving")
    asked = []
    solve = solving.solve_rows

    def counted(binding, bind_input, targets, weights, begin, end, *rest):
        asked.append((begin, end))
        return solve(binding, bind_input, targets, weights, begin, end, *rest)

    monkeypatch.setattr(solving, "solve_rows", counted)
    return asked


def test_nothing_changed_nothing_to_do(saved, monkeypatch, part, capfd):
    obj, control, path = saved
    bake()
    stamp = path.stat().st_mtime_ns
    asked = solved_rows(monkeypatch, part)
    bake()
    assert "Nothing has changed since 'Tube' was baked" in capfd.readouterr().out
    assert (asked, path.stat().st_mtime_ns) == ([], stamp)
    obj.modifiers.clear()
    bake()
    assert (asked, path.stat().st_mtime_ns) == ([], stamp)
    assert obj.modifiers[0].type == 'MESH_CACHE'
    curves(control)[0].keyframe_points[1].co.y += 0.5
    bake()
    assert asked == [(0, FRAMES)]
    assert len(obj.modifiers) == 1


def test_what_was_solved_before_it_was_stopped_is_not_solved_again(saved, monkeypatch, part, rows):
    _obj, _control, path = saved
    bake()
    whole = path.read_bytes()
    bpy.ops.meanvalue.unbake(delete_files=True)
    plan = part("bake.plan")
    monkeypatch.setattr(plan.BakePlan, "chunks", lambda _self: [(0, 5), (5, 10), (10, FRAMES)])
    solving = part("bake.solving")
    solve, asked = solving.solve_rows, []

    def stopped(binding, bind_input, targets, weights, begin, end, *rest):
        if len(asked) == 2:
            raise part("errors").CancelledError("stopped")
        asked.append((begin, end))
        return solve(binding, bind_input, targets, weights, begin, end, *rest)

    monkeypatch.setattr(solving, "solve_rows", stopped)
    assert bpy.ops.meanvalue.bake() == {'CANCELLED'}
    assert not path.exists()
    assert sorted(each.name for each in path.with_name("Tube.chunks").glob("*.json")) == [
        "+000001_+000005.json", "+000006_+000010.json",
    ]  # fmt: skip
    monkeypatch.setattr(solving, "solve_rows", solve)
    asked = solved_rows(monkeypatch, part)
    bake()
    assert asked == [(10, FRAMES)]
    assert path.read_bytes() == whole
    assert sorted(each.name for each in path.parent.iterdir()) == ["Tube.pc2", "Tube.pc2.json"]


def test_a_part_is_baked_again(saved, rows):
    _obj, control, path = saved
    bake()
    before = rows(path)
    curve = curves(control)[0]
    for point in curve.keyframe_points:
        point.co.y += 0.5
    curve.update()
    bake(use_part=True, part_start=4, part_end=6)
    after = rows(path)
    assert np.array_equal(after[[0, 1, 2, *range(6, FRAMES)]], before[[0, 1, 2, *range(6, FRAMES)]])
    assert np.abs(after[3:6] - before[3:6]).max() > 0.4
    report = json.loads(pathlib.Path(f"{path}.json").read_text())
    assert [each["frame"] for each in report["frames"]] == list(range(1, FRAMES + 1))
    bake()
    assert np.abs(rows(path) - before).max(axis=(1, 2)).min() > 0.4  # all of it, now


def test_a_part_needs_the_cache_as_it_was(saved):
    with steps.refused("no point cache", "Part Only"):
        bpy.ops.meanvalue.bake(use_part=True, part_start=1, part_end=2)
    bake()
    with steps.refused("12 samples", "6 of"):
        bpy.ops.meanvalue.bake(step=2, use_part=True, part_start=1, part_end=2)
    with steps.refused("not in the range"):
        bpy.ops.meanvalue.bake(use_part=True, part_start=50, part_end=60)


def test_remove_bake_takes_back_what_bake_made(tmp_path):
    obj, _control = animated_tube(live=True)
    save(tmp_path)
    bpy.context.scene.frame_set(5)
    before = snapshot(obj)
    assert obj.meanvalue.live
    bake()
    assert not obj.meanvalue.live
    assert obj.data.shape_keys.key_blocks["Mean-Value"].mute
    assert len(obj.modifiers) == 1
    assert bpy.ops.meanvalue.unbake() == {'FINISHED'}
    assert_same(before, snapshot(obj))
    assert (tmp_path / "meanvalue_cache" / "Tube.pc2").exists()
    bake()
    assert bpy.ops.meanvalue.unbake(delete_files=True) == {'FINISHED'}
    assert list((tmp_path / "meanvalue_cache").iterdir()) == []
    assert not bpy.ops.meanvalue.unbake.poll()


def test_live_does_not_move_the_mesh_twice(tmp_path, rows):
    obj, _control = animated_tube(live=True)
    save(tmp_path)
    bake()
    assert np.array_equal(played(obj, range(1, FRAMES + 1)), rows(tmp_path / "meanvalue_cache" / "Tube.pc2"))


def test_undo_takes_it_back_and_redo_plays_the_file(saved, rows):
    _obj, _control, path = saved
    bpy.ops.ed.undo_push(message="before")
    bake()
    bpy.ops.ed.undo_push(message="baked")
    bpy.ops.ed.undo()
    obj = bpy.data.objects["Tube"]
    assert len(obj.modifiers) == 0
    assert obj.meanvalue.baked.target == ""
    bpy.ops.ed.redo()
    assert np.array_equal(played(bpy.data.objects["Tube"], [1, 7]), rows(path)[[0, 6]])


# -- reports ---------------------------------------------------------------------------------------------------------


def test_the_report_has_every_frame(saved, capfd):
    _obj, _control, path = saved
    bake()
    report = json.loads(pathlib.Path(f"{path}.json").read_text())
    frames = report["frames"]
    assert [each["frame"] for each in frames] == list(range(1, FRAMES + 1))
    assert all(each["energy"] >= 0.0 and each["converged"] in {True, False} for each in frames)
    worst = max(frames, key=lambda each: each["energy"])
    assert report["worst"][0] == {"frame": f"{worst['frame']:.0f}", "energy": worst["energy"]}
    assert (report["object"], report["blend"]) == ("Tube", "scene.blend")
    assert f"the highest energy is {worst['energy']:.3g} at frame {worst['frame']:.0f}" in capfd.readouterr().out


# -- refusals --------------------------------------------------------------------------------------------------------


def test_an_unsaved_file_has_no_place_for_the_cache(tmp_path, rows):
    obj, _control = animated_tube()
    before = snapshot(obj)
    with steps.refused("not saved yet", "shape keys"):
        bpy.ops.meanvalue.bake()
    assert_same(before, snapshot(obj))
    bake(path=str(tmp_path / "own"))
    assert np.array_equal(played(obj, [3]), rows(tmp_path / "own.pc2")[2:3])


@pytest.mark.parametrize(("options", "texts"), [
    ({"frame_range": 'OWN', "frame_start": 5, "frame_end": 4}, ["ends before it begins"]),
    ({"frame_range": 'PREVIEW'}, ["no preview range"]),
    ({"path": "//"}, ["folder"]),
    ({"path": "relative.pc2"}, ["no full path"]),
    ({"use_part": True, "part_start": 3, "part_end": 2}, ["part ends before it begins"]),
])  # fmt: skip
def test_refused_options(saved, options, texts):
    obj, _control, _path = saved
    before = snapshot(obj)
    with steps.refused(*texts):
        bpy.ops.meanvalue.bake(**options)
    assert_same(before, snapshot(obj))
    assert bpy.context.scene.frame_current == 1


def test_a_size_that_would_hurt_asks(saved):
    with steps.refused("GB", "confirm_size"):
        bpy.ops.meanvalue.bake(frame_range='OWN', frame_start=1, frame_end=900_000)
    with steps.refused("901 shape keys", "confirm_size"):
        bpy.ops.meanvalue.bake(target='SHAPE_KEYS', keys='EVERY', frame_range='OWN', frame_start=0, frame_end=900)


def test_files_of_others_are_not_overwritten(saved, rows):
    obj, _control, path = saved
    path.parent.mkdir()
    path.write_text("precious")
    with steps.refused("something else than a bake", "Overwrite"):
        bpy.ops.meanvalue.bake()
    assert path.read_text() == "precious"
    bake(overwrite='ANY')
    assert len(rows(path)) == FRAMES
    with steps.refused("baked already"):
        bpy.ops.meanvalue.bake(overwrite='NEVER')
    bpy.ops.object.duplicate()
    copy = bpy.context.object
    assert copy != obj
    assert bpy.ops.meanvalue.own_controls() == {'FINISHED'}
    with steps.refused("the bake of 'Tube'"):
        bpy.ops.meanvalue.bake(path=str(path))


def test_a_full_disk_leaves_scene_and_old_cache(saved, part, monkeypatch):
    obj, control, path = saved
    bake()
    curves(control)[0].keyframe_points[1].co.y += 0.5
    before, kept = snapshot(obj), path.read_bytes()

    def full(_file):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(part("core.whole_files").os, "fsync", full)
    with steps.refused("The disk is full", "bake again"):
        bpy.ops.meanvalue.bake()
    assert_same(before, snapshot(obj))
    assert path.read_bytes() == kept
    assert list(path.parent.rglob("*.tmp.*")) == []


def test_a_control_that_is_scaled_to_nothing_is_told_with_its_frame(saved):
    obj, control, path = saved
    control.scale = (1.0, 1.0, 1.0)
    obj.scale = (1.0, 1.0, 1.0)
    obj.keyframe_insert("scale", frame=4)
    obj.scale = (0.0, 0.0, 0.0)
    obj.keyframe_insert("scale", frame=5)
    with steps.refused("At frame 5", "scaled to nothing"):
        bpy.ops.meanvalue.bake()
    assert bpy.context.scene.frame_current == 1
    assert not path.exists()


def test_an_edited_mesh_must_be_looked_at(saved):
    obj, _control, _path = saved
    bake()
    bpy.ops.meanvalue.unbake()
    steps.edit_mesh(obj, lambda mesh: mesh.verts.new((0.0, 0.0, 0.0)))
    with steps.refused("stale", "Bind"):
        bpy.ops.meanvalue.bake()


# -- objects ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["a/b", "..", "手" * 21, "x'\"\\[]", "CON"])
def test_odd_names(tmp_path, name, rows):
    obj, _control = animated_tube(name)
    save(tmp_path)
    bake()
    path = pathlib.Path(bpy.path.abspath(obj.modifiers[0].filepath))
    assert path.parent == tmp_path / "meanvalue_cache"
    assert np.array_equal(played(obj, [1, 8]), rows(path)[[0, 7]])


def test_a_copy_with_the_same_mesh_has_a_cache_of_its_own(saved, rows, tmp_path):
    obj, _control, path = saved
    bake()
    bpy.ops.object.duplicate(linked=True)
    copy = bpy.context.object
    assert copy.data == obj.data
    assert bpy.ops.meanvalue.own_controls() == {'FINISHED'}
    bpy.context.scene.frame_set(1)
    meshes.activate(copy)
    bake()
    assert len(copy.modifiers) == 1
    own = tmp_path / "meanvalue_cache" / f"{bpy.path.clean_name(copy.name)}.pc2"
    assert own.exists()
    bpy.ops.meanvalue.unbake(delete_files=True)
    assert not own.exists()
    assert np.array_equal(played(obj, [4]), rows(path)[3:4])


def test_removing_the_bake_of_a_copy_keeps_the_originals_file(saved):
    _obj, _control, path = saved
    bake()
    bpy.ops.object.duplicate()
    assert bpy.ops.meanvalue.unbake(delete_files=True) == {'FINISHED'}
    assert path.exists()


def test_an_object_that_is_deleted_while_it_is_sampled(saved, part):
    obj, _control, _path = saved
    preparing, scene = part("bake.preparing"), bpy.context.scene
    options = _options(obj, part)
    preparation = preparing.Preparation(obj, scene, options)

    def find():
        if scene.frame_current > 5:
            raise part("errors").SceneError("'Tube' is gone")
        return obj

    with pytest.raises(part("errors").SceneError, match="gone"):
        list(preparation.sample(find))
    assert scene.frame_current == 1


def test_sampling_that_is_dropped_puts_the_frame_back(saved, part):
    obj, _control, _path = saved
    bpy.context.scene.frame_set(3)
    sampling = part("bake.preparing").Preparation(obj, bpy.context.scene, _options(obj, part)).sample(lambda: obj, 0.0)
    next(sampling)
    next(sampling)
    assert bpy.context.scene.frame_current == 2
    sampling.close()
    assert bpy.context.scene.frame_current == 3


def _options(obj, part):
    names = part("bake_settings").NAMES
    return types.SimpleNamespace(**{name: getattr(obj.meanvalue.bake, name) for name in names}, confirm_size=False)


def test_posing_on_does_not_move_a_baked_mesh_twice(saved, rows):
    obj, _control, path = saved
    bake(target='SHAPE_KEYS', keys='EVERY')
    baked = played(obj, [1, 6])
    obj.meanvalue.live = True
    assert np.abs(played(obj, [1, 6]) - baked).max() < 1e-6
    obj.meanvalue.live = False
    assert bpy.ops.meanvalue.solve() == {'FINISHED'}
    assert np.abs(played(obj, [1, 6]) - baked).max() < 1e-6
    bake()
    assert np.array_equal(played(obj, [1, 6]), rows(path)[[0, 5]])
