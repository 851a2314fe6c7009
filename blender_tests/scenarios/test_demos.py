# SPDX-License-Identifier: GPL-3.0-or-later
"""What the demos make, at low resolution, by the operators."""

import dataclasses

import bpy
import numpy as np
import pytest
from support import meshes, steps

from blender_tests.demo import arguments, built_in, game_figure, pose, ready, user_file
from blender_tests.demo.bones import played
from blender_tests.demo.character import drag, dressed, measured
from blender_tests.demo.example import run as example
from blender_tests.demo.joints import SUBJECTS, add_body, both, off_rest
from blender_tests.demo.mirror import both_poses, half_figure, raise_hand
from blender_tests.demo.rig import figures
from blender_tests.demo.walk import capture, measures, subjects

# -- walk --------------------------------------------------------------------------------------------------------------


#: The figure of blended bones is what a well made rig would show: from 41 markers alone the mesh cannot be there to the
#: millimetre, and the distances are stated for that.
SPACING = 0.03  # 2,400 vertices
FRAMES = 70


@pytest.fixture
def carried(tmp_path):
    """make(subjects.walk) is the subject and what became of it."""

    def make(maker, **options):
        subject = maker(tmp_path, spacing=SPACING, **options)
        return subject, capture.carry(subject, tmp_path)

    return make


@pytest.mark.slow
def test_the_walk_comes_near_the_skinned_figure(carried):
    subject, result = carried(subjects.walk, frames=FRAMES)
    height = subject.height
    assert result.shapes.shape == subject.truth.shape and len(result.anchors) == 41
    assert bpy.context.scene.render.fps == 100
    assert [modifier.type for modifier in bpy.data.objects["walk"].modifiers] == ['MESH_CACHE']
    assert np.nanmax(measures.misses(result)) < 0.01 * height
    assert measures.rms(result.shapes, subject.truth).max() < 0.02 * height
    assert measures.rms(measures.laid_on(result.shapes, subject.truth), subject.truth).max() < 0.012 * height
    assert measures.slide(result.shapes, subject.planted) < 0.01 * height
    assert measures.hover(result.shapes, subject.vertices, subject.planted) < 0.01
    assert measures.roughness(result.shapes).max() < 0.01 * height


@pytest.mark.slow
def test_the_walk_plays_as_bones_too(carried):
    subject, result = carried(subjects.walk, frames=30)
    pose.call(bpy.ops.meanvalue.bake, target="ARMATURE", frame_range="SCENE", confirm=True)
    shapes, bones = played(bpy.data.objects["walk"])
    assert 0.0 < measures.rms(shapes, result.shapes).max() < 0.01 * subject.height
    assert bones.shape[:2] == (30, len(bpy.data.objects["walk"].meanvalue.baked.rig.pose.bones))


@pytest.mark.slow
def test_without_a_static_trial_soles_are_on_the_floor_too(tmp_path):
    subject = dataclasses.replace(subjects.walk(tmp_path, spacing=0.026, frames=2 * FRAMES), standing=None)
    result = capture.carry(subject, tmp_path)
    assert measures.rms(measures.laid_on(result.shapes, subject.truth), subject.truth).max() < 0.025 * subject.height
    assert measures.hover(result.shapes, subject.vertices, subject.planted) < 0.01
    assert measures.slide(result.shapes, subject.planted) < 0.01 * subject.height


@pytest.mark.slow
def test_shorter_legs_stand_still(carried):
    subject, result = carried(subjects.short_legs, frames=FRAMES)
    assert subject.height < 1.6
    assert measures.slide(result.shapes, subject.planted) < 0.01 * subject.height
    assert measures.hover(result.shapes, subject.vertices, subject.planted) < 0.01
    assert np.nanmax(measures.misses(result)) < 0.01 * subject.height


@pytest.mark.slow
def test_sitting_down_ends_on_the_box(carried):
    subject, result = carried(subjects.sit, frames=185)
    top = subject.box[1][2]
    seated = result.shapes[180]
    over_box = (seated[:, 1] > subject.box[0][1] + 0.05) & (np.abs(seated[:, 0]) < 0.2)
    assert abs(seated[over_box, 2].min() - top) < 0.03
    assert measures.rms(result.shapes, subject.truth).max() < 0.02 * subject.height
    assert measures.slide(result.shapes, subject.planted) < 0.01 * subject.height


# -- the files that are left, and those that are given -----------------------------------------------------------------


def test_the_octopus_follows_its_control_when_it_is_opened(part, tmp_path):
    subject = built_in.octopus()
    pose.pose_by_operators(subject)
    solved = steps.key_positions(subject.obj, subject.obj.meanvalue.result_key)
    size = np.linalg.norm(np.ptp(pose.positions(subject.obj), axis=0))
    ready.to_be_tried(subject)
    obj = steps.reopened(subject.obj, tmp_path / "octopus.blend")
    settings = obj.meanvalue
    control = settings.handles["tip"].control
    assert bpy.context.object == control and control.select_get() and settings.live
    assert [key.name for key in obj.data.shape_keys.key_blocks] == ["Basis", settings.result_key]
    bpy.context.view_layer.update()
    shown = steps.key_positions(obj, settings.result_key)
    assert np.abs(shown - solved).max() < 0.02 * size

    control.location.z += 0.05 * size
    bpy.context.view_layer.update()
    moved = steps.key_positions(obj, settings.result_key)
    tip = pose.group_indices(obj, "tip")
    assert np.allclose(moved[tip] - shown[tip], (0.0, 0.0, 0.05 * size), atol=1e-3 * size)
    assert part("live.engine").status(obj) is None


@pytest.mark.parametrize("ending", [".glb", ".vrm"])
def test_a_game_character_is_posed_whole_with_rig_and_texture(tmp_path, monkeypatch, ending):
    """Its glove goes along. Its sleeve, which shares a mesh, would stay behind and is hidden; its shoe is not."""
    monkeypatch.setattr(game_figure, "SPACING", 0.05)
    game_figure.write(tmp_path / "figure.glb")
    path = (tmp_path / "figure.glb").rename(tmp_path / f"figure{ending}")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    options = arguments.parse([str(path)])
    user_file.load(options)
    body, rig = (next(each for each in bpy.data.objects if each.type == kind) for kind in ('MESH', 'ARMATURE'))
    assert body.material_slots[0].material.node_tree.nodes.get("Image Texture").image
    for name, place in (("Glove", (0.6, 0.0, 1.4)), ("Sleeve", (0.6, 0.0, 1.4)), ("Shoe", (0.1, -0.1, 0.02))):
        worn = meshes.grid(name=name, columns=2, rows=2)
        worn.scale, worn.location = (0.02,) * 3, place
        worn.modifiers.new("Armature", 'ARMATURE').object = rig
    bpy.data.objects["Shoe"].copy().data = bpy.data.objects["Sleeve"].data
    monkeypatch.setattr(user_file, "load", lambda _options: body)
    subject = user_file.user_subject(options)
    pose.pose_by_operators(subject)
    rest, shown = pose.positions(body), pose.positions(body, pose.result_key(body))
    size = np.linalg.norm(np.ptp(rest, axis=0))
    assert np.linalg.norm(shown - rest, axis=1).max() > 0.1 * size
    places, number = np.unique(rest.round(6), axis=0, return_inverse=True)
    assert len(places) < 0.95 * len(rest), "it is split at its seams"
    first = np.unique(number, return_index=True)[1][number.reshape(-1)]
    assert np.abs(shown - shown[first]).max() < 1e-4 * size
    user_file.hide_what_would_stay_behind(subject)
    assert [bpy.data.objects[each].hide_render for each in ("Glove", "Sleeve", "Shoe")] == [False, True, False]


# -- example -----------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_examples_of_the_rig_halve_the_error_around_joints():
    figure = figures.walker(spacing=SPACING)
    obj, truths, shapes, _seconds = example.carry(figure)
    assert sum(key.name.startswith("Rig Pose") for key in obj.data.shape_keys.key_blocks) == 10
    for where, (without, with_examples) in example.errors(figure, truths, shapes).items():
        assert with_examples < 0.6 * without, where


def test_bones_are_more_rigid_at_joints():
    make, moves, _azimuth = SUBJECTS["finger"]
    figure = make()
    everywhere, at_joints = both(figure, add_body(figure)[0], moves)
    assert off_rest(figure, at_joints) < 0.75 * off_rest(figure, everywhere)


@pytest.mark.slow
def test_what_a_character_wears_goes_along_whole():
    body, worn = dressed(figures.walker(spacing=SPACING))
    drag(body)
    assert {line.object for line in body.meanvalue.along if line.is_taken} == {*worn}
    below, skin, cloth = measured(body, worn)
    assert below < 0.003 and cloth < 1.1 * skin
    moved = []
    for obj in (body, bpy.data.objects["Shirt"]):
        rest, posed = pose.positions(obj), pose.positions(obj, pose.result_key(obj))
        moved.append((posed - rest)[np.abs(rest[:, 0] - 0.63) < 0.03].mean(axis=0))
    assert np.linalg.norm(moved[0]) > 0.3 and np.abs(moved[0] - moved[1]).max() < 0.02, "the hand is in its sleeve"


# -- mirror ------------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_seam_stays_in_its_plane():
    obj, shoulder = half_figure(spacing=SPACING)
    seam = np.abs(pose.positions(obj)[:, 0]) < 1e-6
    assert seam.sum() > 20
    raise_hand(obj, shoulder)
    alone, whole = both_poses(obj)
    assert np.abs(alone[seam, 0]).max() > 0.01
    assert np.abs(whole[seam, 0]).max() == 0.0
    assert np.abs(whole - pose.positions(obj)).max() > 0.2, "the hand is raised"
