# SPDX-License-Identifier: GPL-3.0-or-later
"""The .blend files of `./dev demo` are there to be tried: they open with handles, Live on and the pose shown. Files of
game characters are posed with what belongs to them."""

import bpy
import numpy as np
import pytest
from support import meshes, steps

from blender_tests.demo import arguments, built_in, game_figure, pose, ready, user_file


def test_the_octopus_follows_its_control_when_it_is_opened(part, tmp_path):
    subject = built_in.octopus()
    pose.pose_by_operators(subject)
    solved = steps.key_positions(subject.obj, subject.obj.meanvalue.result_key)
    size = np.linalg.norm(np.ptp(pose.positions(subject.obj), axis=0))
    ready.to_be_tried(subject)
    path = tmp_path / "octopus.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.open_mainfile(filepath=str(path))

    obj = bpy.data.objects["Octopus"]
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
    """Its sleeve would stay behind and is hidden; its shoe is not."""
    monkeypatch.setattr(game_figure, "SPACING", 0.05)
    game_figure.write(tmp_path / "figure.glb")
    path = (tmp_path / "figure.glb").rename(tmp_path / f"figure{ending}")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    options = arguments.parse([str(path)])
    user_file.load(options)
    body, rig = (next(each for each in bpy.data.objects if each.type == kind) for kind in ('MESH', 'ARMATURE'))
    assert body.material_slots[0].material.node_tree.nodes.get("Image Texture").image
    for name, place in (("Sleeve", (0.6, 0.0, 1.4)), ("Shoe", (0.1, -0.1, 0.02))):
        worn = meshes.grid(name=name, columns=2, rows=2)
        worn.scale, worn.location = (0.02,) * 3, place
        worn.modifiers.new("Armature", 'ARMATURE').object = rig
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
    assert [each.hide_render for each in map(bpy.data.objects.get, ("Sleeve", "Shoe"))] == [True, False]
