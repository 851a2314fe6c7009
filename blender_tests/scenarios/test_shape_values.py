# SPDX-License-Identifier: GPL-3.0-or-later
"""Import Shape Key Values: from files of values by name to F-curves of the keys that the mesh has."""

import json

import bpy
import numpy as np
import pytest
from support import mixed_limbs, take_files

CSV = "Timecode,BlendShapeCount,JawOpen,MouthSmileLeft,HeadYaw\n" + "".join(
    f"00:00:00:{frame:02d}.5,61,{frame / 60:.4f},{1 - frame / 60:.4f},0.1\n" for frame in range(60)
)


@pytest.fixture
def face():
    """An object with three shape keys, active."""
    rest = mixed_limbs.rest()
    return mixed_limbs.limb("Face", jaw_open=rest + np.array([0, 0, 0.1]), mouthSmile_L=rest * 1.1, Other=rest * 0.9)


def run(path, content=CSV, **options):
    path.write_text(content)
    return bpy.ops.meanvalue.import_values(filepath=str(path), **options)


def keyed(obj, name):
    return take_files.keys(obj.data.shape_keys, f'key_blocks["{name}"].value')


def test_values_are_keyed_by_name_from_the_current_frame_on(face, tmp_path, capfd):
    scene = bpy.context.scene
    scene.render.fps = 30
    scene.frame_set(11)
    assert run(tmp_path / "take.csv") == {'FINISHED'}
    assert "60 frames of 2 shape keys" in (said := capfd.readouterr().out) and "No shape key for 'HeadYaw'" in said
    found = keyed(face, "jaw_open")
    assert np.allclose(found[:, 0], 11 + np.arange(60) / 2, atol=1e-4)
    assert np.allclose(found[:, 1], np.arange(60) / 60, atol=1e-4)
    assert len(keyed(face, "mouthSmile_L")) == 60
    scene.frame_set(41)
    assert face.data.shape_keys.key_blocks["jaw_open"].value == pytest.approx(59 / 60, abs=1e-4)
    assert face.data.shape_keys.key_blocks["mouthSmile_L"].value == pytest.approx(1 / 60, abs=1e-4)


def test_what_is_animated_is_replaced_only_when_that_is_wanted(face, tmp_path, capfd):
    key = face.data.shape_keys.key_blocks["jaw_open"]
    key.value = 0.5
    key.keyframe_insert("value", frame=3)
    with pytest.raises(RuntimeError, match="'jaw_open' is animated already"):
        run(tmp_path / "take.csv")
    assert keyed(face, "jaw_open").tolist() == [[3.0, 0.5]]
    assert len(keyed(face, "mouthSmile_L")) == 0
    assert run(tmp_path / "take.csv", replace=True) == {'FINISHED'}
    assert len(keyed(face, "jaw_open")) == 60


def test_names_rate_and_scale_of_the_artist(face, tmp_path):
    frames = [{"Mouth": 50.0, "jawOpen": None}, {"Mouth": 75.0, "jawOpen": 1.0}]
    bpy.context.scene.render.fps = 24
    options = {"names": "Mouth=Other", "rate": 48.0, "scale": 0.01}
    assert run(tmp_path / "take.json", json.dumps(frames), **options) == {'FINISHED'}
    assert np.allclose(keyed(face, "Other"), [[1.0, 0.5], [1.5, 0.75]])
    assert np.allclose(keyed(face, "jaw_open"), [[1.5, 0.01]])


def test_driven_muted_and_short_ranges_are_told(face, tmp_path, capfd):
    keys = face.data.shape_keys.key_blocks
    keys["jaw_open"].driver_add("value")
    keys["mouthSmile_L"].mute = True
    keys["mouthSmile_L"].slider_max = 0.5
    assert run(tmp_path / "take.csv") == {'FINISHED'}
    said = capfd.readouterr().out
    assert "Drivers set 'jaw_open'" in said and "'mouthSmile_L' is muted" in said and "beyond" in said
    assert len(keyed(face, "mouthSmile_L")) == 60


@pytest.mark.parametrize(
    "content, words",
    [
        ("time,JawOpen\n0,1\n1,high\n", "line 3"),
        ("time,Nose\n0,1\n", "No shape key of 'Face' has a name of the file"),
    ],
)
def test_what_cannot_be_read_changes_nothing(face, tmp_path, content, words):
    with pytest.raises(RuntimeError, match=words):
        run(tmp_path / "take.csv", content)
    assert face.data.shape_keys.animation_data is None


def test_meshes_without_shape_keys_and_absolute_ones_say_so(face, tmp_path):
    face.data.shape_keys.use_relative = False
    with pytest.raises(RuntimeError, match="absolute"):
        run(tmp_path / "take.csv")
    face.shape_key_clear()
    with pytest.raises(RuntimeError, match="no shape keys besides the Basis"):
        run(tmp_path / "take.csv")
