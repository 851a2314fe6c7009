# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/core/capture/: what all formats have in common (units, axes, refusals), and real C3D files."""

import json
import os

import numpy as np
import pytest

from addon.capture.core import c3d_file, marker_sets, readers, units
from addon.errors import MotionFileError
from blender_tests.support import capture_files, walker
from blender_tests.support.capture_files import has_note
from blender_tests.support.mesh_files import path_of

METRES = walker.positions()
#: Of float32 at these sizes, in metres.
FLOAT_ERROR = 5e-7
#: Sitting, Z up, in metres: nobody stands on a floor here.
SEATED = {"LSHO": (-0.18, 0.0, 0.9), "RSHO": (0.18, 0.0, 0.9), "HEAD": (0.0, 0.03, 1.1), "STERNUM": (0.0, 0.12, 0.8),
          "LELB": (-0.3, 0.0, 0.7), "RELB": (0.3, 0.0, 0.7), "FRAMEL": (-0.25, -0.1, 0.45)}  # fmt: skip


def read_c3d(content, **options):
    return c3d_file.read(content, "take.c3d", **options)


# -- units and axes --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("unit, metres", [
    ("mm", 0.001), ("cm", 0.01), ("m", 1.0), ("Meters", 1.0), ("in", 0.0254), (" MM ", 0.001), (["cm"] * 8, 0.01),
    (["deg", *["mm"] * 6, "m"], [*[0.001] * 7, 1.0]),
])  # fmt: skip
def test_positions_are_in_metres_whatever_the_unit_or_the_units_of_the_markers(unit, metres):
    take = read_c3d(capture_files.c3d(walker.LABELS, METRES / np.reshape(metres, (-1, 1)), unit=unit))
    assert np.abs(take.positions - METRES).max() < FLOAT_ERROR
    assert take.notes == ()


@pytest.mark.parametrize(
    "metres, name", [(0.001, "millimeters"), (0.01, "centimeters"), (1.0, "meters"), (0.0254, "inches")]
)
@pytest.mark.parametrize("unit", [None, "furlong"])
def test_an_unknown_unit_is_guessed_by_the_size_of_the_subject_and_told(metres, name, unit):
    take = read_c3d(capture_files.c3d(walker.LABELS, METRES / metres, unit=unit))
    assert np.abs(take.positions - METRES).max() < FLOAT_ERROR
    assert has_note(take, name, "are assumed")
    assert has_note(take, "furlong") == (unit == "furlong")


def test_a_unit_of_choice_overrules_the_file():
    take = read_c3d(capture_files.c3d(walker.LABELS, 100.0 * METRES, unit="mm"), unit=0.01)
    assert np.abs(take.positions - METRES).max() < FLOAT_ERROR
    for wrong in (0.0, -1.0, np.nan):
        with pytest.raises(MotionFileError, match="unit"):
            read_c3d(capture_files.c3d(walker.LABELS, METRES), unit=wrong)


def test_a_unit_of_choice_that_makes_no_person_is_followed_and_told():
    take = read_c3d(capture_files.c3d(walker.LABELS, 1000.0 * METRES, unit="mm"), unit=1e-5)
    assert np.abs(take.positions - 0.01 * METRES).max() < FLOAT_ERROR
    assert has_note(take, "By the chosen unit", " m large", "0.001 m for a unit")
    assert not has_note(read_c3d(capture_files.c3d(walker.LABELS, 100.0 * METRES), unit=0.01), "By the chosen unit")


@pytest.mark.parametrize("told, factor, meant", [("m", 1e3, 1), ("mm", 1.0, 1), ("mm", 100.0, 1), ("mm", 1e-3, 1e-6)])
def test_a_unit_by_which_nobody_is_that_large_gives_way_to_one_that_fits_and_that_is_told(told, factor, meant):
    take = read_c3d(capture_files.c3d(walker.LABELS, factor * METRES, unit=told))
    assert has_note(take, "By the file the subject is", "choose" if meant < 1 else "1.7 m is assumed")
    assert take.positions[0, 0, 2] == pytest.approx(meant * METRES[0, 0, 2])


@pytest.mark.parametrize("metres, unit", [(1.0, "m"), (0.0254, "in"), (0.001, "furlong")])
def test_what_stands_far_from_a_person_does_not_change_the_size(metres, unit):
    there = np.concatenate([METRES, np.broadcast_to([[5.0, 0.0, 1.0], [-5.0, 0.0, 1.0]], (len(METRES), 2, 3))], axis=1)
    take = read_c3d(capture_files.c3d([*walker.LABELS, "wall 1", "wall 2"], there / metres, unit=unit))
    assert np.abs(take.positions - there).max() < FLOAT_ERROR


def turned(up):
    """The walk as a file has it whose axis `up` is up, right-handed."""
    axis = "XYZ".index(up[-1])
    rotation = np.zeros((3, 3))
    rotation[:, axis] = (0.0, 0.0, -1.0 if up[0] == "-" else 1.0)
    rotation[0, (axis + 1) % 3] = 1.0
    rotation[:, (axis + 2) % 3] = np.cross(rotation[:, axis], rotation[:, (axis + 1) % 3])
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    return METRES @ rotation


@pytest.mark.parametrize("up", units.UP_AXES)
def test_up_comes_from_the_file_or_by_choice_and_nothing_is_mirrored(up):
    across = "+X" if up[-1] != "X" else "+Y"
    screen = (across, up if up[0] == "-" else f"+{up}")
    by_file = read_c3d(capture_files.c3d(walker.LABELS, turned(up), unit="m", screen=screen))
    by_choice = read_c3d(capture_files.c3d(walker.LABELS, turned(up), unit="m", screen=("+X", "+Y")), up_axis=up)
    for take in (by_file, by_choice):
        assert np.abs(take.positions[..., 2] - METRES[..., 2]).max() < FLOAT_ERROR
        # The same but for a turn about Z: triple products of three markers keep their sign.
        edges = take.positions[:, 1:4] - take.positions[:, :1]
        wanted = METRES[:, 1:4] - METRES[:, :1]
        assert np.linalg.det(edges) == pytest.approx(np.linalg.det(wanted), abs=1e-6)


def test_a_silent_file_is_stood_upright_by_its_markers():
    for up in units.UP_AXES:
        for labels in (walker.LABELS, "ABCDEFGH") if up in "YZ" else (walker.LABELS,):
            take = read_c3d(capture_files.c3d(labels, turned(up), unit="m", screen=None))
            assert np.abs(take.positions[..., 2] - METRES[..., 2]).max() < FLOAT_ERROR
            assert has_note(take, f"{up} is assumed", "parts of the body")


@pytest.mark.parametrize("told, header", [(0.02, 0.06), (0.06, 0.02), (0.06, 0.06), (0.0, 0.06), (0.1, -0.1)])
def test_of_two_scales_the_one_of_a_person_is_taken(told, header):
    parts = {"scale": -0.1 if header < 0.0 else 0.06, "point": {"SCALE": told}, "header": {"scale": header}}
    take = read_c3d(capture_files.c3d(walker.LABELS, 1000.0 * METRES, **parts))
    assert np.abs(take.positions - METRES).max() < 4e-5
    assert has_note(take, "1.7 m is assumed") == (told == 0.02)


@pytest.mark.parametrize("screen", [("-X", "-Z"), ("+X", "-Z"), ("+Y", "-Z"), ("+X", "+Y"), ("+X", "+Z")])
def test_axes_of_the_screen_give_way_to_where_head_and_feet_are(screen):
    for labels in (walker.LABELS, "ABCDEFGH") if screen[1] != "+Y" else (walker.LABELS,):
        take = read_c3d(capture_files.c3d(labels, 1000.0 * METRES, screen=screen))
        assert np.abs(take.positions[..., 2] - METRES[..., 2]).max() < 1e-6
        assert has_note(take, f"says that {screen[1].lstrip('+')} is up: Z is taken") == (screen[1] != "+Z")


def test_an_arm_that_reaches_out_does_not_overrule_the_file():
    arm = 1000.0 * (np.outer(np.arange(4), (0.0, 0.2, -0.02)) + (0.2, 0.0, 1.0) + 0.01 * METRES[:, :4])
    take = read_c3d(capture_files.c3d(["LSHO", "LELB", "LWRA", "LFIN"], arm))
    assert np.abs(1000.0 * take.positions - arm).max() < 1e-3


@pytest.mark.parametrize("labels", [walker.LABELS, "ABCDEFGH"])
def test_who_lies_throughout_is_not_stood_up(labels):
    lies = METRES[:, :, [2, 0, 1]] - np.nanmin(METRES[:, :, [2, 0, 1]], axis=(1), keepdims=True) + (1.2, -0.3, 0.05)
    take = read_c3d(capture_files.c3d(labels, 1000.0 * lies, screen=None))
    assert np.abs(take.positions - lies).max() < 1e-5


@pytest.mark.parametrize("order", [(1, 2, 0), (0, 2, 1), (2, 0, 1), (0, 1, 2)])
def test_a_seated_person_without_axes_sits_upright(order):
    seated = np.array(list(SEATED.values())) + 0.03 * np.sin(np.arange(40)[:, None, None] / 4 + np.arange(7)[:, None])
    take = read_c3d(capture_files.c3d(list(SEATED), 1000.0 * seated[..., order], screen=None))
    assert np.abs(take.positions[..., 2] - seated[..., 2]).max() < 1e-6


# -- tables, as makers of captures write them, made up ---------------------------------------------------------------


def rows(positions, *before, missing="", comma=","):
    """Lines of numbers; before: functions of the number of the row."""
    for number, places in enumerate(positions):
        cells = [missing if np.isnan(value) else f"{value:.6f}" for value in places.ravel()]
        yield comma.join([*(format(cell(number), ".12g") for cell in before), *cells])


GAPS = walker.with_gaps(METRES, (1, 3, 7), (7, 0, 2))
NAMED = ",".join(f"{label}_{axis}" for label in walker.LABELS for axis in "xyz")
#: Frames 12, 13, ... of 120 a second, of which every second is written; each marker is there as solved too.
MOTIVE = "Format Version,1.24,Capture Frame Rate,120.0,Export Frame Rate,60.0,Length Units,Meters\n\n,Type"
MOTIVE += ",Marker" * 24 + ",Bone Marker" * 24 + "\n,Name," + ",".join(np.repeat([*walker.LABELS] * 2, 3)) + "\n,"
MOTIVE += ",Position" * 48 + "\nFrame,Time (Seconds)" + ",X,Y,Z" * 16 + "\n"
MOTIVE += "\n".join(rows(np.hstack([GAPS[..., [1, 2, 0]]] * 2), lambda k: 12 + k, lambda k: 0.2 + k / 60))
NEXUS = "Devices\n1000\n,,Force,,\nFrame,Sub Frame,Fx,Fy,Fz\n,,N,N,N\n1,0,1,2,3\n\nTrajectories\n60\n,"
NEXUS += "".join(f",Ann:{name},," for name in walker.LABELS) + f"\nFrame,Sub Frame{',X,Y,Z' * 8}\n,{',mm' * 24}\n"
OUTPUTS = "\n\nModel Outputs\n60\n,,Ann:LKneeAngles,,\nFrame,Sub Frame,X,Y,Z\n,,deg,deg,deg\n1,0,1,2,3\n"
QTM = "NO_OF_FRAMES\t20\nFREQUENCY\t60\nMARKER_NAMES\t" + "\t".join(walker.LABELS) + "\n"
TABLES = {
    "motive": MOTIVE,
    "nexus.csv": NEXUS + "\n".join(rows(1000.0 * GAPS, lambda k: k + 1, lambda k: 0)) + OUTPUTS,
    "qtm.tsv": QTM + "TRAJECTORY_TYPES\tMeasured\n" + "\n".join(rows(1000.0 * GAPS, missing="0.0", comma="\t")),
    "qtm times.tsv": QTM + "\n".join(rows(1000.0 * GAPS, lambda k: k + 1, lambda k: k / 60, missing="0.0", comma="\t")),
    "freemocap.csv": "timestamp,timestamp_by_camera,body_" + NAMED.replace(",", ",body_") + ",nose_rotation_x\n"
    + "\n".join(f'{1e8 + k / 60:.6f},"{{0: 1.5, 1: 1.5}}",{row},9' for k, row in enumerate(rows(1000.0 * GAPS))),
    "german.csv": "Zeit ms;" + NAMED.replace("_", "_position_").replace(",", " [mm];") + " [mm]\n"
    + "\n".join(rows(1000.0 * GAPS, lambda k: 1000 * k / 60, comma=";")).replace(".", ","),
    "a point a row.csv": "time,name,X,Y,Z\n" + "\n".join(f"{k / 60:.6f},{name},{x},{y},{z}" for k in range(20)
    for name, (x, y, z) in zip(walker.LABELS, GAPS[k], strict=True) if x == x),
    "named.json": json.dumps({"fps": 60, "frames": [{"points": [{"name": name, "x": x, "y": y, "z": z}
    for name, (x, y, z) in zip(walker.LABELS, each, strict=True) if x == x]} for each in GAPS.tolist()]}),
}  # fmt: skip


@pytest.mark.parametrize("name", TABLES)
def test_tables_of_makers_are_read_upright_in_metres_in_time(name):
    take = readers.parse(TABLES[name].encode(), name)
    assert [label.rpartition(":")[2].removeprefix("body_") for label in take.labels] == [*walker.LABELS]
    assert take.rate_hz == pytest.approx(60.0, rel=1e-3) and take.start_s == 0.2 * (name == "motive")
    away = (np.linalg.norm(each - each[0, 0], axis=2) for each in (take.positions, GAPS))
    assert np.nanmax(np.abs(np.subtract(*away))) < 1e-5
    assert np.allclose(take.positions[..., 2], GAPS[..., 2], atol=1e-5, equal_nan=True), "up is up"


def test_of_motive_bones_are_a_skeleton_and_what_has_no_name_is_no_marker():
    take = readers.parse(MOTIVE.replace("HEAD", "Unlabeled 7").encode(), "take.csv")
    assert take.labels == walker.LABELS[1:] and take.left_out["unlabelled points"] == ("Unlabeled 7",)
    assert readers.parse(MOTIVE.replace("Bone Marker", "Bone").replace("Marker", "Bone").encode(), "b").is_skeleton


def test_numbered_points_of_mediapipe_at_uneven_times_are_named_and_brought_to_a_rate():
    body, times = np.resize(METRES, (20, 33, 3)), np.delete(np.arange(20), [4, 5, 11])
    head = ",".join(["timestamp_ms", *(f"{axis}{number}" for number in range(33) for axis in "xyz")])
    take = readers.parse("\n".join([head, *rows(body[times], lambda k: 40 * times[k])]).encode(), "pose.csv", "Z", 1.0)
    assert None not in marker_sets.recognise(take.labels).landmarks and take.labels[32] == "right_foot_index"
    assert take.rate_hz == 25.0 and take.frames == 20 and has_note(take, "not evenly spaced")
    assert np.allclose(take.positions[[*times, 11]], [*body[times], body[[10, 12]].mean(axis=0)], atol=1e-5)
    flat = [{"keypoints_2d": [1.0] * 75, "keypoints_3d": [*each]} for each in body[:, :25].reshape(20, 75)]
    assert readers.parse(json.dumps(flat).encode(), "pose.json", "Z", 1.0).labels[19] == "LBigToe"


def test_of_a_file_a_frame_any_one_is_the_take_of_the_first_person(tmp_path):
    body = np.resize(METRES, (20, 25, 3))
    for number in {*range(20)} - {4, 5}:
        people = [{"pose_keypoints_3d": [*np.insert(shift + body[number], 3, 0.9, 1).ravel()]} for shift in (0.0, 1.0)]
        content = json.dumps({"version": 1.3, "people": people[: 2 * (number > 0)]})
        (tmp_path / f"w1_{number:012}_keypoints.json").write_text(content)
    (tmp_path / "w2_000000000000_keypoints.json").write_text("another take")
    for chosen in (0, 7):  # in the first nobody is seen
        along = set()
        path = tmp_path / f"w1_{chosen:012}_keypoints.json"
        take = readers.read(path, up_axis="Z", unit=1.0, along=along)
        wanted = body[1:] - body[1, 0]
        wanted[3:5] = wanted[2] + (wanted[5] - wanted[2]) * np.array([1, 2])[:, None, None] / 3
        assert take.labels[8] == "MidHip" and np.allclose(take.positions - take.positions[0, 0], wanted, atol=1e-5)
        assert len(along) == 18 and path in along
    (tmp_path / "w1_000000000003_keypoints.json").write_text('{"people": [}')
    with pytest.raises(MotionFileError, match=r"^w1_000000000003_keypoints\.json, line 1"):
        readers.read(path)


@pytest.mark.parametrize("form", [lambda at: at, lambda at: {"instances": [{"keypoints": at, "scores": [1] * 17}]},
    lambda at: [{"keypoints": at, "bbox": [1, 2]}, {"keypoints": at[::-1], "bbox": [3, 4]}]])  # fmt: skip
def test_lists_of_persons_or_points_are_of_one_frame_and_files_are_one_take_if_numbered_alike(tmp_path, form):
    body = np.resize(METRES, (9, 17, 3))
    for number, points in enumerate(body):
        (tmp_path / f"take_{number}.json").write_text(json.dumps(form(points.tolist())))
        (tmp_path / f"take_{number:02}.json").write_text(json.dumps(form(np.flip(points).tolist())))
        (tmp_path / f"long_{number + 95:02}.json").write_text(json.dumps(form(points.tolist())))
        (tmp_path / f"filled_{number + 995:03}.json").write_text(json.dumps(form(points.tolist())))
    (tmp_path / "filled_094.json").write_text(json.dumps(form(body[0].tolist())))
    flipped = np.flip(body, axis=(1, 2))
    for name, wanted in (("take_3", body), ("take_03", flipped), ("long_96", body), ("long_101", body)):
        assert np.allclose(readers.read(tmp_path / f"{name}.json", up_axis="Z", unit=1.0).positions, wanted)
    for number in ("094", "998", "1002"):
        assert np.allclose(readers.read(tmp_path / f"filled_{number}.json", up_axis="Z", unit=1.0).positions[-9:], body)
    alone = readers.parse(json.dumps(form(body[5].tolist())).encode(), "a.json", "Z", 1).positions
    assert np.allclose(alone[0], body[5]) and len(alone) == (2 if "bbox" in str(form([])) else 1), "of boxes frames"


@pytest.mark.parametrize("form", [
    lambda paths: {f"Joint_{number}": path for number, path in enumerate(paths)},
    lambda paths: {"names": ["a"] * 30, **{f"landmark {number}": path for number, path in enumerate(paths)}},
    lambda paths: {"pose": [dict(zip("xyz", place, strict=True)) for place in paths[0]]},
    lambda paths: [{"bbox": [1, 2], "keypoints": at} for at in zip(*paths, strict=True)],
    lambda paths: [{"bbox": [1, 2], "Frame": row, "keypoints": at} for row, at in enumerate(zip(*paths, strict=True))],
])  # fmt: skip
def test_paths_by_name_and_lists_of_boxes_have_all_their_frames(tmp_path, form):
    content = form(np.resize(METRES, (17, 30, 3)).tolist())
    for number in range(3):
        (tmp_path / f"take_{number}.json").write_text(json.dumps(content))
    assert readers.read(tmp_path / "take_1.json", up_axis="Z", unit=1.0).frames == 30


# -- what is no take -------------------------------------------------------------------------------------------------


def test_files_that_are_none_are_refused_by_name_with_a_remedy(tmp_path):
    for name, content, reason in (
        ("a.fbx", b"", r"'\.fbx' is not read.*\.c3d, \.trc, \.bvh"),
        ("plain", b"", r"is not read"),
        ("a.c3d", b"", r"no C3D file \(it has 0 bytes"),
        ("b.C3D", b"HIER" * 500, "no C3D file"),
        ("c.c3d", b"\x09\x50".ljust(2048, b"\0"), "block 9"),
        ("d.c3d", b"\x02\x50".ljust(2048, b"\0"), "number format 0"),
        ("a.trc", b"", "no names above rows of numbers"),
        ("a.bvh", b"", "no BVH file"),
        ("turns.csv", MOTIVE.replace("Position", "Rotation").encode(), "rotations alone, of 8 segments: .*BVH"),
        ("flat.csv", b"frame,nose_x,nose_y\n0,1,2\n1,1,2\n", "X and Y alone.*TRC"),
        ("face.csv", b"time,jawOpen\n0,1\n1,2\n", "no part of it is a point.*Import Shape Key Values"),
        ("word.csv", b"time,a_x,a_y,a_z\n0,1,2,3\n1,1,2,3\n2,1,gone,3\n", "line 4.*'gone' is no number"),
        ("quote.csv", b'time,a_x,a_y,a_z\n0,1,2,3\n1,1,2,3\n2,"1' + b"\n1" * 140000, "no table"),
        ("pose.json", json.dumps([{"keypoints_2d": [1.0] * 75}] * 2).encode(), "X and Y alone"),
        ("deep.json", b"[" * 200000, "no list of frames"),
        ("walk.amc", b"#!OML:ASF F:\\a\n:FULLY-SPECIFIED\n", "Acclaim"),
    ):
        path = tmp_path / name
        path.write_bytes(content)
        with pytest.raises(MotionFileError, match=reason) as caught:
            readers.read(path)
        assert str(caught.value).startswith(name)


def test_paths_that_are_no_files_are_refused(tmp_path):
    folder = tmp_path / "folder.c3d"
    folder.mkdir()
    pipe = tmp_path / "pipe.trc"
    if hasattr(os, "mkfifo"):  # elsewhere it is missing, as is the next
        os.mkfifo(pipe)
    for path in ("", folder, pipe, tmp_path / "missing.bvh", tmp_path / ("x" * 300 + ".bvh"), "null\0.c3d"):
        with pytest.raises(MotionFileError):
            readers.read(path)


# -- real files ------------------------------------------------------------------------------------------------------


def shared(name):
    return readers.read(path_of(f"mocap/{name}"))


def test_pig_walk_has_35_markers_of_193_points():
    take = shared("pig-walk/PiG_Motion-FlatFoot-One.c3d")
    assert take.positions.shape == (255, 35, 3) and take.rate_hz == 100.0
    assert sum(map(len, take.left_out.values())) == 193 - 35
    counts = {kind: len(names) for kind, names in take.left_out.items()}
    wanted = {"angles": 26, "forces": 20, "moments": 18, "powers": 16, "segment axes": 76, "virtual points": 2}
    assert counts == wanted
    static = shared("pig-walk/PiG_Calibration-FlatFoot-One.c3d")
    assert static.labels == take.labels
    height = np.nanmax(static.positions[..., 2]) - np.nanmin(static.positions[..., 2])
    assert 1.5 < height < 1.9


def test_one_trial_in_three_number_formats():
    floats, dec, sgi = (shared(f"messy/{name}") for name in ("pc_real.c3d", "DEC_INT.C3D", "sgi_int.c3d"))
    step = 0.28118e-3
    for whole in (dec, sgi):
        assert whole.labels == floats.labels and whole.rate_hz == floats.rate_hz
        assert np.array_equal(whole.measured, floats.measured)
        assert np.nanmax(np.abs(whole.positions - floats.positions)) <= 1.001 * step


@pytest.mark.parametrize(
    "name, markers, left_out, frames, missing",
    [("badParameterOffset.c3d", 39, {"never seen": 2}, 111, 0.0), ("mocap36.c3d", 36, {}, 1380, 0.166)],
)
def test_messy_files_are_read(name, markers, left_out, frames, missing):
    take = shared(f"messy/{name}")
    assert take.positions.shape == (frames, markers, 3)
    assert {kind: len(names) for kind, names in take.left_out.items()} == left_out
    assert take.missing_share == pytest.approx(missing, abs=5e-4)
    assert 1.6 < np.nanmax(take.positions[..., 2]) < 1.9  # upright, in metres
    assert np.nanmin(take.positions[..., 2]) > 0.0
