# SPDX-License-Identifier: GPL-3.0-or-later
"""What Bake refuses, with the scene and all files as they were; odd objects and names."""

import os
import pathlib

import bpy
import numpy as np
import pytest
from support import meshes, steps
from support.baking import FRAMES, animated_tube, bake, curves, played, rows, save
from support.snapshot import assert_same, snapshot

# -- refusals --------------------------------------------------------------------------------------------------------


def test_an_unsaved_file_has_no_place_for_the_cache(tmp_path):
    obj, _control = animated_tube()
    with steps.refused("not saved yet", "shape keys", unchanged=obj):
        bpy.ops.meanvalue.bake()
    bake(path=str(tmp_path / "own"))
    assert np.array_equal(played(obj, [3]), rows(tmp_path / "own.pc2")[2:3])


@pytest.mark.parametrize(("options", "texts"), [
    ({"frame_range": 'OWN', "frame_start": 5, "frame_end": 4}, ["ends before it begins"]),
    ({"path": "//"}, ["folder"]),
    ({"path": "relative.pc2"}, ["no full path"]),
    ({"path": "//scene.blend/cache.pc2"}, ["cannot be reached", "another path"]),
    ({"path": "//" + 300 * "x" + ".pc2"}, ["xxx", "Choose another path"]),
])  # fmt: skip
def test_refused_options_are_told_before_any_frame_is_sampled(saved, options, texts):
    obj, _control, _path = saved
    before, visited = snapshot(obj), []

    def remember(scene, *_others):
        visited.append(scene.frame_current)

    bpy.app.handlers.frame_change_pre.append(remember)
    try:
        with steps.refused(*texts):
            bpy.ops.meanvalue.bake(**options)
    finally:
        bpy.app.handlers.frame_change_pre.remove(remember)
    assert_same(before, snapshot(obj))
    assert visited == [] and bpy.context.scene.frame_current == 1


def test_a_size_that_would_hurt_is_asked_about(saved):
    with steps.refused("GB", "confirm=True"):
        bpy.ops.meanvalue.bake(frame_range='OWN', frame_start=1, frame_end=900_000)
    with steps.refused("901 shape keys", "confirm=True"):
        bpy.ops.meanvalue.bake(target='SHAPE_KEYS', frame_range='OWN', frame_start=0, frame_end=900)


def test_it_is_asked_before_files_of_others_are_overwritten(saved, tmp_path):
    obj, _control, path = saved
    path.parent.mkdir(parents=True)
    path.write_text("precious")
    with steps.refused("something else than a bake", "confirm=True"):
        bpy.ops.meanvalue.bake()
    assert path.read_text() == "precious"
    bake(confirm=True)
    assert len(rows(path)) == FRAMES
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "second.blend"))
    with steps.refused("the bake of 'Tube' in 'scene.blend'"):
        bpy.ops.meanvalue.bake(path=str(path))
    bake(path=str(path), confirm=True)
    bpy.ops.object.duplicate()
    copy = bpy.context.object
    assert copy != obj
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    with steps.refused("the bake of 'Tube' in 'second.blend'"):
        bpy.ops.meanvalue.bake(path=str(path))


def test_a_full_disk_leaves_scene_and_old_cache(saved, part, monkeypatch):
    obj, control, path = saved
    bake()
    curves(control)[0].keyframe_points[1].co.y += 0.5
    before, kept = snapshot(obj), path.read_bytes()

    def full(_file):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(part("scene.core.whole_files").os, "fsync", full)
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
    with steps.refused("Update"):
        bpy.ops.meanvalue.bake()


# -- objects ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["a/b", "..", "手" * 21, "x'\"\\[]", "CON", "nul", "dots..."])
def test_odd_names(tmp_path, name):
    obj, _control = animated_tube(name)
    save(tmp_path)
    bake()
    path = pathlib.Path(bpy.path.abspath(obj.modifiers[0].filepath))
    assert path.parent == tmp_path / "meanvalue_cache" / "scene"
    assert pathlib.PureWindowsPath(path.name).stem == path.stem.rstrip(". ")
    assert not pathlib.PureWindowsPath(path.name).is_reserved()
    assert np.array_equal(played(obj, [1, 8]), rows(path)[[0, 7]])


@pytest.mark.parametrize("path", ["//of_windows\\tube.pc2", "//..\\of_windows\\tube.pc2"])
def test_slashes_of_another_system(tmp_path, path):
    obj, _control = animated_tube("Tube")
    beside = tmp_path / "scenes"
    beside.mkdir()
    save(beside)
    bake(path=path)
    made = (tmp_path if ".." in path else beside) / "of_windows" / "tube.pc2"
    assert np.array_equal(played(obj, [1, 8]), rows(made)[[0, 7]])


#: Of another system, or of a drive's own folder.
NO_FULL_PATHS = {"nt": [r"\tube.pc2", "/tube.pc2"], "posix": [r"C:\a\tube.pc2", r"\\server\a\tube.pc2"]}


@pytest.mark.parametrize("path", ["C:tube.pc2", *NO_FULL_PATHS[os.name]])
def test_full_paths_of_another_system_are_refused(saved, path):
    with steps.refused("no full path"):
        bpy.ops.meanvalue.bake(path=path)


def test_a_copy_with_the_same_mesh_has_a_cache_of_its_own(saved, tmp_path):
    obj, _control, path = saved
    bake()
    bpy.ops.object.duplicate(linked=True)
    copy = bpy.context.object
    assert copy.data == obj.data
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    bpy.context.scene.frame_set(1)
    meshes.activate(copy)
    bake()
    assert len(copy.modifiers) == 1
    own = tmp_path / "meanvalue_cache" / "scene" / f"{bpy.path.clean_name(copy.name)}.pc2"
    assert own.exists()
    assert np.array_equal(played(obj, [4]), rows(path)[3:4])
