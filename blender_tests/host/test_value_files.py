# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/sliders/core/: files of shape values, and which names mean the same."""

import json
import random

import numpy as np
import pytest

from addon.errors import MotionFileError, SceneError
from addon.sliders.core import value_files
from blender_tests.fuzz import mutations

#: As Live Link Face writes it, at 60 frames a second.
LIVE_LINK = (
    b"Timecode,BlendShapeCount,EyeBlinkLeft,JawOpen,HeadYaw\n"
    b"11:33:05:58.124,61,0.10,0.20,-0.05\n"
    b"11:33:05:59.124,61,0.15,,-0.04\n"
    b"11:33:06:01.124,61,0.20,0.30,-0.03\n"
)


def csv(text):
    return value_files.parse_csv(text.encode(), "take.csv")


def of_json(value, **options):
    return value_files.parse_json(json.dumps(value).encode(), "take.json", **options)


def test_a_recorder_s_csv_with_timecodes():
    read = value_files.parse_csv(LIVE_LINK, "take.csv")
    assert read.names == ("EyeBlinkLeft", "JawOpen", "HeadYaw")
    assert read.rate_hz == 60.0
    assert np.allclose(read.times, [0, 1, 3])
    assert np.allclose(read.values[:, 0], [0.1, 0.15, 0.2])
    assert np.isnan(read.values[1, 1])
    assert value_files.parse_csv(LIVE_LINK, "take.csv", 120.0).times.tolist() == pytest.approx([0, 1, 63])


@pytest.mark.parametrize(
    "text, times, rate",
    [
        ("time,a\r\n0.5,0\r\n0.75,1\r\n", [0, 250], 1000.0),
        ("info,1\nbs,a,b\nk,7,0,0,1,2,3,4,5,6,7,8,0,1\nk,47,0,0,1,2,3,4,5,6,7,8,1,0\n", [0, 40], 1000.0),  # Face Cap
        ("a-50|b_L-0|=head#1,2|\na-100|\n", [0, 1], 60.0),  # iFacialMocap
        ("time ms;a\n500;0,5\n750;1\n", [0, 250], 1000.0),
        ("Frame a\n10 0\n12 1\n", [0, 2], None),
        (",a\n,0\n,1\n", [0, 1], None),
        ("Timecode,a\n23:59:59:29,0\n00:00:00:00,1\n", [0, 1], 30.0),
        ("Timecode,a\n00:00:01.5,0\n00:00:02,1\n", [0, 12], 24.0),
        ("Timecode,a\n00:00:59;29,0\n00:01:00;02,1\n00:10:00;00,1\n", [0, 1, 16183], 30.0 / 1.001),
        ("# recorded\n# time,a\n0,0\n0.5,1\n", [0, 500], 1000.0),
        ("sep=|\n# a comment, and more\n\nt|a\n0|0\n0.5|1\n", [0, 500], 1000.0),
    ],
)
def test_times_in_csv(text, times, rate):
    read = csv(text)
    assert read.times.tolist() == pytest.approx(times) and read.names[0] == "a" and read.rate_hz == rate


def test_decimal_commas_and_quotes():
    assert csv('time;"jaw; open";b\n0;0,25;1\n').values.tolist() == [[0.25, 1.0]]


@pytest.mark.parametrize(
    "text, words",
    [
        ("", ["line 1", "empty"]),
        ("0.1,0.2\n0.3,0.4\n", ["line 1", "no names"]),
        ("time,a,a\n0,1,2\n", ["line 1", "two columns are called 'a'"]),
        ("time,a\n", ["no whole row"]),
        ("time,a\n0,1\n1,2,3\n2,4\n", ["line 3", "3 columns where the header has 2"]),
        ("time,a\n0,1\n\n1,high\n", ["line 4", "'high' is no number", "'a'"]),
        ("time,a\n0,1\n1,inf\n", ["line 3", "'inf'"]),
        ("time,a\n" + "5,1\n6,1\n7,1\n8,1\n9,1\n" * 2, ["line 7", "before that of the row above"]),
        ("time,a\n0,1\nnoon,1\n", ["line 3", "'noon' is no time"]),
        ("time,a\n0:0:1:2,1\n1:2,1\n", ["line 3", "'1:2' is no timecode"]),
    ],
)
def test_damaged_csv_says_what_is_wrong_in_which_line(text, words):
    with pytest.raises(MotionFileError) as caught:
        csv(text)
    assert str(caught.value).startswith("take.csv")
    assert all(word in str(caught.value) for word in words), caught.value


def test_a_row_that_is_cut_off_is_dropped_and_doubles_are_told():
    assert len(csv("time,a,b\n0,1,2\n1,1").times) == 1
    read = csv("time,a\n0,1\n0,2\n1,3\n")
    assert read.values[:, 0].tolist() == [1.0, 3.0]
    assert "1 row" in read.notes[0]


def test_json_in_its_three_forms():
    by_name = of_json([{"time": 0.0, "a": 0.1}, {"time": 0.5, "a": 0.2, "b": 1}])
    assert by_name.names == ("a", "b")
    assert by_name.times.tolist() == [0.0, 500.0]
    assert np.isnan(by_name.values[0, 1])
    table = of_json({"names": ["a", "b"], "frames": [[0, 1], [1, None]], "fps": 30})
    assert (table.rate_hz, table.clock) == (30.0, "Each row is a frame, 30 a second")
    assert table.times.tolist() == [0.0, 1.0]
    weights = of_json({"exportFps": 60.0, "facsNames": ["a"], "weightMat": [[0.5]]})
    assert (weights.rate_hz, weights.values.tolist()) == (60.0, [[0.5]])
    assert of_json([{"time": 0, "address": "Val", "args": [name, 0.1]} for name in "ab"]).names == ("a", "b"), "VMC"
    assert of_json([{"Hotkey": -1, "Shapes": [{"k": "a", "v": 0.1}]}]).names == ("Hotkey", "a"), "as MeowFace has it"
    nested = of_json([{"frame": 3, "blendShapes": {"a": 0.1}}, {"frame": 5, "blendShapes": {"a": 0.2}}])
    assert (nested.names, nested.times.tolist(), nested.rate_hz) == (("a",), [0.0, 2.0], None)


@pytest.mark.parametrize(
    "content, words",
    [
        (b'[\n{"a": 1},\n{"a": }]', ["line 3"]),
        (b"[" * 100_000, ["no list of frames"]),
        (b"[" + b"1" * 10_000 + b"]", []),
        (b"3", ["no names", 'Give it [{"time"']),
        (b"[]", ["no names"]),
        (b'[{"a": 1}, [2]]', ["frame 2", "not like the first"]),
        (b'[{"a": 1}, {"a": "x"}]', ["frame 2", "'a'", "no number"]),
        (b'[{"a": true}]', ["no names of shapes with numbers", "'a'"]),
        (b'[{"a": NaN}]', ["no names of shapes with numbers"]),
        (b'[{"time": 0}]', ["no names"]),
        (b'{"names": ["a"], "frames": [[1], [1, 2]]}', ["frame 2", "not like the first"]),
        (b'{"names": "a", "frames": [[1]]}', ["no names"]),
    ],
)
def test_damaged_json(content, words):
    with pytest.raises(MotionFileError) as caught:
        value_files.parse_json(content, "take.json")
    assert str(caught.value).startswith("take.json")
    assert all(word in str(caught.value) for word in words), caught.value


@pytest.mark.parametrize("name", ["take.csv", "take.json"])
def test_any_damage_is_read_or_refused(name):
    whole = LIVE_LINK
    if name.endswith("json"):
        whole = json.dumps([{"timecode": "0:0:1:3", "a": 0.5, "b": 0.25}] * 3).encode()
    parse = value_files.parse_csv if name.endswith("csv") else value_files.parse_json
    for seed in range(400):
        content = mutations.mutated(whole, random.Random(seed))
        try:
            read = parse(content, name)
        except MotionFileError as error:
            assert str(error).startswith(name) and len(str(error)) < 500
            continue
        assert read.values.shape == (len(read.times), len(read.names))
        assert np.isfinite(read.times).all() and (np.diff(read.times) > 0.0).all()


def test_files_that_cannot_be_read(tmp_path):
    (tmp_path / "folder.csv").mkdir()
    for path in (tmp_path / "take.fbx", tmp_path / "gone.csv", tmp_path / "folder.csv"):
        with pytest.raises(MotionFileError, match=path.name):
            value_files.read(path)
    with pytest.raises(MotionFileError, match="Use Import Motion Capture"):
        value_files.parse(b"Format Version,1.23\n", "take.csv")


def test_names_are_matched_without_case_and_separators():
    keys = ["Basis", "jaw_open", "eyeBlink_L", "smile"]
    assert value_files.matched(["JawOpen", "EyeBlinkLeft", "HeadYaw"], keys) == {
        "JawOpen": "jaw_open",
        "EyeBlinkLeft": "eyeBlink_L",
    }


def test_the_same_name_goes_before_one_that_is_alike():
    assert value_files.matched(["jawopen", "jawOpen"], ["jawOpen"]) == {"jawOpen": "jawOpen"}
    assert value_files.matched(["Left"], ["left", "L"]) == {"Left": "left"}


def test_names_that_are_given():
    names, keys = ["mouthSmile", "jawOpen", "brow"], ["smile", "jawOpen"]
    found = value_files.matched(names, keys, " mouthSmile = smile ; jawOpen=;")
    assert found == {"mouthSmile": "smile"}
    for text, words in (("smile", "no pair"), ("x=smile", "'x'"), ("brow=y", "'y'")):
        with pytest.raises(SceneError, match=words):
            value_files.matched(names, keys, text)
