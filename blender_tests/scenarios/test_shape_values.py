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

#: Two seconds of two shapes, 30 rows a second.
NAMES, ROWS, SWAPPED = ("JawOpen", "MouthSmileLeft"), range(60), [*range(30), 31, 30, *range(32, 60)]
VALUES = np.round(0.5 + 0.4 * np.sin(np.array(ROWS)[:, None] / [4.0, 5.0]), 4).tolist()
OBJECTS = [dict(zip(NAMES, row, strict=True)) for row in VALUES]
LISTS = {name: list(column) for name, column in zip(NAMES, zip(*VALUES, strict=True), strict=True)}


def table(head, row, order=ROWS):
    """CSV: `head` and the names, then row(number) and the values."""
    return "\n".join(",".join(map(str, each)) for each in ([*head, *NAMES], *([*row(i), *VALUES[i]] for i in order)))


def code(row, rate):
    return f"10:00:{row // rate:02d}:{row % rate:02d}"


def scores(row):
    return [{"index": k, "score": VALUES[row][k], "categoryName": NAMES[k], "displayName": ""} for k in range(2)]


#: Of a recording, in the forms of many recorders: seconds in a scene of 24 frames a second, and rows.
FORMS = {
    "no time.csv": (table([], lambda i: []), 59 / 24, 60),
    "number of a row.csv": (table([""], lambda i: [i]), 59 / 24, 60),
    "numbers of two takes.csv": (table([""], lambda i: [i % 30]), 59 / 24, 60),
    "a shape that rises.csv": (table(["Nose"], lambda i: [i / 59]), 59 / 24, 60),
    "frame, seconds.csv": (table(["frame", "timestamp", "confidence"], lambda i: [i, i / 30, 0.9]), 59 / 30, 60),
    "frame, epoch.csv": (table(["frame", "unix_ms"], lambda i: [i, 1700000000000 + i * 1000 // 30]), 59 / 30, 60),
    "face, microseconds.csv": (table(["face_id", "time"], lambda i: [0, i * 1000000 // 30]), 59 / 30, 60),
    "frame, timecode.csv": (table(["Frame", "Timecode"], lambda i: [i, code(i, 30)]), 59 / 30, 60),
    "dates.csv": (table(["t"], lambda i: [f"2026-01-01T23:59:{59.5 + i / 30:.3f}Z"], range(15)), 14 / 30, 15),
    "one row early.csv": (table(["Timecode"], lambda i: [code(0 if i == 24 else i, 24)]), 59 / 24, 59),
    "one row late.csv": (table(["time"], lambda i: [i / 30 + 99 * (i == 20)]), 59 / 30, 59),
    "two rows swapped.csv": (table(["Timecode"], lambda i: [code(i, 24)], SWAPPED), 59 / 24, 59),
    "a list a shape.json": ({"fps": 30, "shapes": LISTS}, 59 / 30, 60),
    "lists alone.json": (LISTS, 59 / 24, 60),
    "named lists.json": ([{"name": f"a[{name}]", "values": part} for name, part in LISTS.items()], 59 / 24, 60),
    "names and scores.json": ([{"t": i / 30, "faces": [{"categories": scores(i)}]} for i in ROWS], 59 / 30, 60),
    "milliseconds.json": ([{"timestampMs": i * 1000 / 30, "shapes": OBJECTS[i]} for i in ROWS], 59 / 30, 60),
    "beside.json": ({"times": [i / 30 for i in ROWS], "frames": VALUES, "names": NAMES}, 59 / 30, 60),
    "an object a line.ndjson": ("\n".join(json.dumps({"time": i / 30, **OBJECTS[i]}) for i in ROWS), 59 / 30, 60),
}


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


def test_values_are_keyed_by_name_from_the_current_frame_on(face, tmp_path):
    scene = bpy.context.scene
    scene.render.fps = 30
    scene.frame_set(11)
    assert run(tmp_path / "take.csv") == {'FINISHED'}
    found = keyed(face, "jaw_open")
    assert np.allclose(found[:, 0], 11 + np.arange(60) / 2, atol=1e-4)
    assert np.allclose(found[:, 1], np.arange(60) / 60, atol=1e-4)
    assert len(keyed(face, "mouthSmile_L")) == 60
    scene.frame_set(41)
    assert face.data.shape_keys.key_blocks["jaw_open"].value == pytest.approx(59 / 60, abs=1e-4)
    assert face.data.shape_keys.key_blocks["mouthSmile_L"].value == pytest.approx(1 / 60, abs=1e-4)


@pytest.mark.parametrize("name", FORMS)
def test_one_recording_in_forms_of_many_recorders(face, tmp_path, name):
    bpy.context.scene.render.fps = 24
    content, seconds, rows = FORMS[name]
    content = content if isinstance(content, str) else json.dumps(content)
    assert run(tmp_path / name, content, names="jawopen=JAW_OPEN") == {'FINISHED'}
    for key, column in zip(("jaw_open", "mouthSmile_L"), zip(*VALUES, strict=True), strict=True):
        found = keyed(face, key)
        assert len(found) == rows and found[-1, 0] - found[0, 0] == pytest.approx(24 * seconds, abs=0.03)
        assert found[[0, 10, -1], 1] == pytest.approx([column[0], column[10], column[rows - 1 if rows < 20 else -1]])


def test_what_is_animated_is_replaced_only_when_that_is_wanted(face, tmp_path):
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


def test_driven_muted_and_short_ranges_are_no_hindrance(face, tmp_path):
    keys = face.data.shape_keys.key_blocks
    keys["jaw_open"].driver_add("value")
    keys["mouthSmile_L"].mute = True
    keys["mouthSmile_L"].slider_max = 0.5
    assert run(tmp_path / "take.csv") == {'FINISHED'}
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
