# SPDX-License-Identifier: GPL-3.0-or-later
"""Characters of other files, posed in this one: a tube on a rig, with a sleeve."""

import bpy
import numpy as np
import pytest
from support import baking, handles, installed, libraries, meshes, rigs, steps

TIP, OFFSET, RINGS = handles.TOP[0], (0.7, -0.4, 0.9), handles.RINGS


def write_library(path, rings=RINGS, wide=1.0):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    installed.enable()
    obj, armature = rigs.arm(name="Character")
    if rings != RINGS:
        obj.data = meshes.tube(rings, handles.SEGMENTS, "Other").data
    obj.data.transform(np.diag([wide, 1.0, 1.0, 1.0]))
    around = [(1.4 * np.cos(a), 1.4 * np.sin(a), 0.6 * ring) for ring in range(9, 17) for a in range(6)]
    sleeve = meshes.make_object(around, meshes.grid_faces(6, 8), "Sleeve")
    sleeve.modifiers.new("Armature", 'ARMATURE').object = armature
    steps.add_group(sleeve, "Lower", range(len(around)))
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_factory_settings(use_empty=True)


@pytest.fixture
def character(tmp_path):
    write_library(tmp_path / "library.blend")
    installed.enable()
    for each in libraries.load(tmp_path / "library.blend", "objects", ["Character", "Sleeve", "Rig"], link=True):
        each.override_create(remap_local_usages=True)
    rigs.bend(overridden("Rig"), 60.0)
    return overridden("Character")


def overridden(name="Character"):
    return bpy.data.objects[name, None]


def pose_of(obj):
    return installed.part("scene.pose_objects").of(obj)


def grab(obj):
    steps.run(obj, "grab", vertex=TIP, offset=OFFSET)
    rigs.update()
    return pose_of(obj)


def test_the_first_press_makes_what_holds_the_pose_and_discard_takes_it_away(character, capfd):
    objects, sleeve = set(bpy.data.objects), overridden("Sleeve")
    before, worn = meshes.seen(character), meshes.seen(sleeve)
    character.override_library.is_system_override = True
    posed = grab(character)
    control = posed.meanvalue.handles[0].control
    assert set(bpy.data.objects) - objects == {posed, control, pose_of(sleeve)}
    assert "'Character Pose' holds the pose of 'Character'" in capfd.readouterr().out
    assert np.allclose(meshes.seen(character)[TIP] - before[TIP], OFFSET, atol=1e-3)
    assert np.abs(meshes.seen(character) - meshes.seen(posed)).max() < 1e-6
    assert np.abs(meshes.seen(sleeve) - worn).max() > 0.3
    assert bpy.context.object == character and not posed.visible_get() and posed.hide_render
    assert [each.name for each in character.modifiers] == ["Pose", "Armature"]
    rigs.bend(overridden("Rig"), 20.0)
    assert np.allclose(control.matrix_world.translation, meshes.seen(character)[TIP], atol=1e-3)
    double = character.copy()
    bpy.context.collection.objects.link(double)
    assert grab(double) not in (None, posed) and pose_of(character) == posed
    for each in (double, character):
        steps.run(each, "finish", keep='NOTHING')
    bpy.data.objects.remove(double)
    assert set(bpy.data.objects) == objects and not bpy.data.node_groups and len(character.modifiers) == 1


def test_kept_poses_play_without_the_add_on_under_any_names_and_on_a_new_library(character, tmp_path):
    posed, path = grab(character), str(tmp_path / "shot.blend")
    steps.run(character, "keep_pose", name="Reach")
    key = posed.data.shape_keys.key_blocks["Reach"]
    for key.value in (0.0, 1.0):
        key.keyframe_insert("value", frame=1 + 10 * key.value)
    bpy.context.scene.frame_set(11)
    rigs.bend(overridden("Rig"), 0.0)
    offset = meshes.seen(character) - baking.rest(character)
    for each in (posed, posed.data, character.modifiers[0], character.modifiers[0].node_group, key):
        each.name = "Other"
    bpy.ops.wm.save_as_mainfile(filepath=path)
    for rings, wide in ((RINGS, 1.0), (RINGS, 1.5), (RINGS + 1, 1.0)):
        write_library(tmp_path / "library.blend", rings, wide)
        bpy.ops.wm.open_mainfile(filepath=path)
        rigs.bend(overridden("Rig"), 0.0)
        for frame in (11, 1):
            bpy.context.scene.frame_set(frame)
            moved = meshes.seen(overridden()) - baking.rest(overridden())
            assert np.abs(moved - (offset if rings == RINGS and frame > 1 else 0.0)).max() < 1e-5
    assert offset.max() > 0.6
    problem = installed.part("scene.subject").object_problem(pose_of(overridden()))
    assert "has 144 vertices now, and its pose is of 136: it waits in 'Other'" in problem


def test_handles_go_on_with_the_shape_that_the_library_has_now(character, tmp_path, status):
    posed, path = grab(character), str(tmp_path / "shot.blend")
    rigs.bend(overridden("Rig"), 0.0)
    offset = meshes.seen(character) - baking.rest(character)
    bpy.ops.wm.save_as_mainfile(filepath=path)
    for wide in (np.nan, 1.5):  # a shape that is none is waited out
        write_library(tmp_path / "library.blend", wide=wide)
        installed.enable()
        bpy.ops.wm.open_mainfile(filepath=path)
        bpy.ops.wm.save_mainfile()
    character, posed = overridden(), pose_of(overridden())
    rest = installed.part("scene.shape_keys").rest_positions
    assert np.array_equal(rest(posed.data), rest(character.data))
    assert np.abs(meshes.seen(character) - baking.rest(character) - offset).max() < 1e-5
    posed.update_tag()
    rigs.update()
    assert "press Update" in status(posed)[0]
    steps.run(character, "bind")
    rigs.update()
    before = meshes.seen(character)[TIP]
    assert np.abs(before - baking.rest(character)[TIP] - offset[TIP]).max() < 1e-3
    handles.move(posed.meanvalue.handles[0].control, (0.3, 0.0, 0.0))
    assert np.abs(meshes.seen(character)[TIP] - before - (0.3, 0.0, 0.0)).max() < 1e-3


@pytest.mark.parametrize("target", ['POINT_CACHE', 'SHAPE_KEYS'])
def test_bakes_are_seen(character, tmp_path, target):
    steps.run(character, "add_handle", group="Lower")
    baking.key_control(pose_of(character).meanvalue.handles["Lower"].control)
    bpy.context.scene.frame_end = baking.FRAMES
    baking.save(tmp_path)
    meshes.activate(character)
    live = baking.played(character, (1, 5, 9))
    assert np.ptp(live, axis=0).max() > 0.5
    baking.bake(target=target)
    assert np.abs(baking.played(character, (1, 5, 9)) - live).max() < 1e-3
    rigs.bend(overridden("Rig"), 0.0)
    offset = meshes.seen(character) - baking.rest(character)
    bpy.ops.wm.save_mainfile()
    path = bpy.data.filepath
    write_library(tmp_path / "library.blend", wide=1.5)
    installed.enable()
    bpy.ops.wm.open_mainfile(filepath=path)
    character = overridden()
    assert np.abs(meshes.seen(character) - baking.rest(character) - offset).max() < 1e-5 < np.ptp(offset)
    steps.run(character, "unbake")
    rigs.update()
    assert np.array_equal(baking.rest(pose_of(character)), baking.rest(character))
    assert np.abs(meshes.seen(character) - baking.rest(character) - offset).max() < 1e-3


def test_a_bake_that_is_kept_is_kept_of_clothes_too(character, tmp_path):
    baking.key_control(grab(character).meanvalue.handles[0].control)
    baking.save(tmp_path)
    meshes.activate(character)
    baking.bake(target='POINT_CACHE')
    worn = meshes.seen(overridden("Sleeve"))
    steps.run(character, "unbake", keep_bake=True)
    assert np.array_equal(meshes.seen(overridden("Sleeve")), worn)
