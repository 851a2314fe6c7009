# SPDX-License-Identifier: GPL-3.0-or-later
"""Import Motion Capture: from a file to animated Empties."""

import bpy
import numpy as np
import pytest
from support import capture_files, meshes, steps, take_files


def blocks():
    return {
        name: sorted(block.name for block in getattr(bpy.data, name))
        for name in ("objects", "collections", "actions", "meshes")
    }


@pytest.mark.parametrize("rate, fps, base", [(100.0, 24, 1.0), (119.88, 30, 1.001), (30.0, 30, 1.0), (10.0, 24, 1.0)])
def test_one_second_stays_one_second(tmp_path, rate, fps, base):
    scene = bpy.context.scene
    scene.render.fps, scene.render.fps_base = fps, base
    labels, positions = take_files.waves()
    take = take_files.bring_in(take_files.write_trc(tmp_path / "swing.trc", labels, positions, rate), start_frame=11)
    assert (scene.render.fps, round(scene.render.fps_base, 6)) == (fps, base)
    for empty in take.objects:
        frames = take_files.keys(empty, "location")[:, 0]
        seconds = (frames - 11.0) * base / fps
        assert np.allclose(seconds, np.arange(120) / rate, atol=1e-5 * 120)
    assert scene.frame_end >= frames[-1]


def test_the_scene_may_take_the_rate_of_the_capture(tmp_path):
    scene = bpy.context.scene
    labels, positions = take_files.waves()
    path = take_files.write_trc(tmp_path / "swing.trc", labels, positions, 119.88)
    take = take_files.bring_in(path, time='CAPTURE')
    assert scene.render.fps / scene.render.fps_base == pytest.approx(119.88, rel=1e-6)
    assert np.array_equal(take_files.keys(take.objects[0], "location")[:, 0], np.arange(1, 121))


def test_markers_are_where_the_file_says(tmp_path):
    labels, positions = take_files.waves()
    take = take_files.bring_in(take_files.write_trc(tmp_path / "swing.trc", labels, positions))
    assert take.name == "swing"
    assert [empty.meanvalue.marker for empty in take.objects] == list(labels)
    for number, empty in enumerate(take.objects):
        values = np.stack([take_files.keys(empty, "location", axis)[:, 1] for axis in range(3)], axis=1)
        assert np.array_equal(values.astype(np.float32), positions[:, number])
        assert (empty.type, empty.empty_display_type) == ('EMPTY', 'SPHERE')
    for sample in (0, 17, 119):
        steps.go_to(1.0 + sample * 0.24)
        shown = np.array([empty.matrix_world.translation for empty in take.objects])
        assert np.allclose(shown, positions[sample], atol=1e-5)


def test_unit_scale_and_up_axis_of_the_artist(tmp_path):
    labels, positions = take_files.waves()
    path = take_files.write_trc(tmp_path / "swing.trc", labels, positions, unit="mm")
    take = take_files.bring_in(path, up_axis='Y', unit='CENTIMETRES', scale=2.0)
    steps.go_to(1.0)
    for number, empty in enumerate(take.objects):
        x, y, z = positions[0, number] * 0.02
        assert empty.matrix_world.translation.z == pytest.approx(y, abs=1e-6)
        assert sorted(map(abs, empty.matrix_world.translation)) == pytest.approx(sorted(map(abs, (x, y, z))), abs=1e-6)


def test_gaps_are_no_keys_and_never_zeros(tmp_path):
    labels, positions = take_files.waves()
    positions[20:40, 1] = positions[:7, 2] = positions[100:, 3] = np.nan
    take = take_files.bring_in(take_files.write_trc(tmp_path / "gaps.trc", labels, positions))
    empties = {empty.meanvalue.marker: empty for empty in take.objects}
    for number, label in enumerate(labels):
        found = take_files.keys(empties[label], "location")
        samples = np.rint((found[:, 0] - 1.0) / 0.24).astype(int)
        assert np.array_equal(samples, np.flatnonzero(~np.isnan(positions[:, number, 0])))
        present = ~np.isnan(positions[:, number, 0])
        curve = take_files.keys(empties[label], "meanvalue.influence")
        assert (len(curve) == 0) == present.all()
        for sample in range(0, 120, 3):
            steps.go_to(1.0 + 0.24 * sample + 0.01)
            assert empties[label].meanvalue.influence == (1.0 if present[sample] else 0.0), (label, sample)
            near = np.abs(np.array(empties[label].location) - np.nanmean(positions[:, number], axis=0))
            assert near.max() < 0.5, (label, sample)  # not at the origin


def imported(path, **options):
    """The range of the scene after importing a file into one of 10 frames."""
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 10
    take_files.bring_in(path, time='CAPTURE', **options)
    return scene.frame_start, scene.frame_end


def test_ends_without_any_marker_are_left_out_of_the_range(tmp_path):
    labels, positions = take_files.waves()
    positions[:30] = positions[95:] = np.nan
    path = take_files.write_trc(tmp_path / "ends.trc", labels, positions)
    assert imported(path) == (31, 95)
    take = bpy.data.collections["ends"]
    assert np.array_equal(take_files.keys(take.objects[0], "location")[:, 0], np.arange(31, 96))
    assert imported(path, extend_range=False) == (1, 10)
    whole = take_files.write_trc(tmp_path / "whole.trc", *take_files.waves())
    assert imported(whole) == (1, 120)


def test_a_marker_that_is_never_seen_gets_no_empty(tmp_path):
    labels, positions = take_files.waves()
    positions[:, 2] = np.nan
    take = take_files.bring_in(take_files.write_trc(tmp_path / "unseen.trc", labels, positions))
    assert [empty.meanvalue.marker for empty in take.objects] == [label for label in labels if label != "M2"]


def test_several_files_at_once(tmp_path):
    labels, positions = take_files.waves()
    for name, begin in (("one.trc", 0.0), ("two.trc", 0.5)):
        (tmp_path / name).write_bytes(capture_files.trc(labels, positions, unit="m", begin=begin))
    files = [{"name": "one.trc"}, {"name": "two.trc"}]
    assert bpy.ops.meanvalue.import_motion(files=files, directory=str(tmp_path), up_axis='Z') == {'FINISHED'}
    assert [collection.name for collection in bpy.data.collections] == ["one", "two"]
    assert all(len(collection.objects) == 5 for collection in bpy.data.collections)
    first = [take_files.keys(collection.objects[0], "location")[0, 0] for collection in bpy.data.collections]
    assert first == [1.0, 13.0], "half a second later"


def test_one_undo_takes_all_of_it_back(tmp_path):
    meshes.grid()
    bpy.ops.ed.undo_push(message="Before")
    scene = bpy.context.scene
    before = blocks(), scene.frame_end, scene.render.fps
    labels, positions = take_files.waves(frames=2000)
    take_files.bring_in(take_files.write_trc(tmp_path / "swing.trc", labels, positions), time='CAPTURE')
    assert blocks() != before[0]
    bpy.ops.ed.undo_push(message="Import")
    bpy.ops.ed.undo()
    scene = bpy.context.scene
    assert (blocks(), scene.frame_end, scene.render.fps) == before


def test_wrong_files_are_refused_by_name_and_leave_nothing(tmp_path):
    labels, positions = take_files.waves()
    take_files.write_trc(tmp_path / "good.trc", labels, positions)
    (tmp_path / "bad.trc").write_text("not a motion file\n")
    before = blocks()
    files = [{"name": "good.trc"}, {"name": "bad.trc"}]
    folder = str(tmp_path)
    for named, options in (
        ("bad.trc", {"filepath": f"{folder}/bad.trc"}),
        ("missing.trc", {"filepath": f"{folder}/missing.trc"}),
        ("bad.trc", {"files": files, "directory": folder}),
        ("No file is chosen", {"filepath": ""}),
        ("this is a folder", {"filepath": folder + "/"}),
        ("this is a folder", {"filepath": folder}),
    ):
        with steps.refused(named):
            bpy.ops.meanvalue.import_motion(**options)
    assert blocks() == before


def test_only_takes_of_bvh_are_skeletons(tmp_path):
    labels, positions = take_files.waves()
    markers = take_files.bring_in(take_files.write_trc(tmp_path / "swing.trc", labels, positions))
    assert not markers.meanvalue.is_skeleton
    channels = ("Xposition", "Yposition", "Zposition")
    chain = ("Hips", (0, 0, 0), channels, [("Spine", (0, 50, 0), (), [(None, (0, 60, 0), (), ())])])
    (tmp_path / "chain.bvh").write_bytes(capture_files.bvh(chain, [[0.0, 90.0, 0.0]] * 3))
    assert take_files.bring_in(tmp_path / "chain.bvh").meanvalue.is_skeleton


def test_a_mesh_that_is_worked_on_stays_active_and_gets_the_take(tmp_path):
    obj = meshes.grid()
    labels, positions = take_files.waves()
    take = take_files.bring_in(take_files.write_trc(tmp_path / "swing.trc", labels, positions))
    assert bpy.context.object == obj
    assert obj.meanvalue.capture.take == take
    assert [pair.name for pair in obj.meanvalue.capture.pairs] == list(labels)


def test_what_was_edited_is_read_back(tmp_path, part):
    labels, positions = take_files.waves()
    positions[50:60, 0] = np.nan
    take = take_files.bring_in(take_files.write_trc(tmp_path / "swing.trc", labels, positions))
    takes = part("capture.bridge.takes")
    read = takes.read(take)
    assert np.array_equal(read.positions.astype(np.float32), positions, equal_nan=True)
    assert np.allclose(read.frames, 1.0 + 0.24 * np.arange(120))
    curves = list(take_files.curves(take.objects[1]))
    for curve in curves:
        curve.keyframe_points.remove(curve.keyframe_points[7])
    assert np.isnan(takes.read(take).positions[7, 1]).all()
    for factor in (1.5, 2.0 / 1.5):
        for key in curves[0].keyframe_points:
            key.co.x *= factor
        curves[0].update()
        with pytest.raises(part("errors").SceneError, match=r"Undo what stretched them"):
            takes.read(take)


def test_markers_under_a_moved_parent_are_read_where_they_are(tmp_path, part):
    labels, positions = take_files.waves()
    take = take_files.bring_in(take_files.write_trc(tmp_path / "swing.trc", labels, positions))
    stand = meshes.new_object("Stand")
    stand.location, stand.scale = (1.0, 2.0, 3.0), (2.0, 2.0, 2.0)
    for empty in take.objects:
        empty.parent = stand
    bpy.context.view_layer.update()
    read = part("capture.bridge.takes").read(take)
    assert np.allclose(read.positions, 2.0 * positions + (1.0, 2.0, 3.0), atol=1e-5)
