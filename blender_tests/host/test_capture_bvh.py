# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/core/capture/: BVH files."""

import numpy as np
import pytest

from addon.capture.core import bvh_file
from addon.errors import MotionFileError
from blender_tests.support import capture_files
from blender_tests.support.capture_files import has_note
from blender_tests.support.mesh_files import content_of

MOVES, TURNS = ("Xposition", "Yposition", "Zposition"), ("Zrotation", "Xrotation", "Yrotation")
#: In centimetres, Y up.
LEG = ("Knee", (0.0, -45.0, 0.0), ("Xrotation",), [(None, (0.0, -42.0, 0.0), (), [])])
HEAD = ("Head", (0.0, 25.0, 2.0), ("Yrotation", "Zrotation", "Xrotation"), [(None, (0.0, 20.0, 0.0), (), [])])
SPINE = ("Chest", (0.0, 30.0, 0.0), ("Zrotation", "Xrotation", "Yrotation"), [HEAD])
FIGURE = ("Hips", (0.0, 0.0, 0.0), (*MOVES, "Zrotation", "Yrotation", "Xrotation"), [LEG, SPINE])
#: All bones lie along X at rest; where the legs turn by half a turn, it stands along the X of the hips.
ALONG_X = ("Hips", (0, 0, 0), (*MOVES, *TURNS), [
    ("Spine", (20, 0, 0), TURNS, [("Head", (40, 0, 0), (), [(None, (20, 0, 0), (), [])])]),
    *[(f"{side}UpLeg", (0, 0, z), TURNS, [(f"{side}Leg", (42, 0, 0), (), [
        (f"{side}Foot", (43, 0, 0), (), [(None, (5, 0, 0), (), [])])])]) for side, z in (("Left", 9), ("Right", -9))],
])  # fmt: skip
LABELS = ("Hips", "Knee", "Knee_end", "Chest", "Head", "Head_end")


def read_bvh(content, **options):
    return bvh_file.read(content, "walk.bvh", **options)


def moves(frames=4):
    rng = np.random.default_rng(7)
    motion = rng.uniform(-90.0, 90.0, (frames, 13))
    motion[:, :3] = np.array((3.0, 95.0, -4.0)) + rng.normal(size=(frames, 3))
    return np.round(motion, 6)


def by_hand(motion):
    """(f, 6, 3) centimetres: chains of 4 x 4 matrices, joint by joint."""
    result = []
    for row in motion:
        hips = move(*row[:3]) @ turn("Z", row[3]) @ turn("Y", row[4]) @ turn("X", row[5])
        knee = hips @ move(0, -45, 0) @ turn("X", row[6])
        chest = hips @ move(0, 30, 0) @ turn("Z", row[7]) @ turn("X", row[8]) @ turn("Y", row[9])
        head = chest @ move(0, 25, 2) @ turn("Y", row[10]) @ turn("Z", row[11]) @ turn("X", row[12])
        chain = [hips, knee, knee @ move(0, -42, 0), chest, head, head @ move(0, 20, 0)]
        result.append([matrix[:3, 3] for matrix in chain])
    return np.array(result)


def move(x, y, z):
    matrix = np.eye(4)
    matrix[:3, 3] = (x, y, z)
    return matrix


def turn(axis, degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    matrix = np.eye(4)
    matrix[:3, :3] = {
        "X": [(1, 0, 0), (0, c, -s), (0, s, c)],
        "Y": [(c, 0, s), (0, 1, 0), (-s, 0, c)],
        "Z": [(c, -s, 0), (s, c, 0), (0, 0, 1)],
    }[axis]
    return matrix


def test_bvh_joints_are_where_the_chain_of_matrices_puts_them():
    motion = moves()
    take = read_bvh(capture_files.bvh(FIGURE, motion))
    x, y, z = np.moveaxis(0.01 * by_hand(motion), 2, 0)
    assert np.abs(take.positions - np.stack([x, -z, y], axis=2)).max() < 1e-9
    assert take.labels == LABELS and take.is_skeleton
    assert take.rate_hz == 120.0
    assert has_note(take, "centimeters are assumed") and has_note(take, "Y is assumed", "parts of the body")


@pytest.mark.parametrize("order", ["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"])
def test_bvh_channels_in_any_order_also_between_each_other(order):
    rotations = [f"{axis}rotation" for axis in order]
    channels = (rotations[0], "Zposition", rotations[1], "Xposition", "Yposition", rotations[2])
    content = capture_files.bvh(("Root", (0, 0, 0), channels, [(None, (0, 170, 0), (), [])]), [[10, 3, 20, 1, 2, 30]])
    matrix = move(1, 2, 3) @ turn(order[0], 10) @ turn(order[1], 20) @ turn(order[2], 30)
    take = read_bvh(content, up_axis="Z", unit=1.0)
    assert np.abs(take.positions[0, 1] - (matrix @ (0, 170, 0, 1))[:3]).max() < 1e-9


def rows(upright=(90, 0, 0), hips=(0, 95, 0), travel=(0, 0, 3), bent=0):
    """The motion of ALONG_X, whose trunk is bent by a right angle in the first `bent` frames."""
    motion = np.zeros((40, 15))
    motion[:, :3] = np.add(hips, np.outer(np.arange(40), travel))
    motion[:, 3:6], motion[:, [9, 12]], motion[:bent, 6] = upright, 180.0, -90.0
    return motion


@pytest.mark.parametrize("motion, head, foot", [
    (rows(), 1.55, 0.10), (rows(bent=15), 1.55, 0.10), (rows()[:1], 1.55, 0.10),
    (rows(upright=(0, 0, -90), hips=(0, 0, 95), travel=(3, 0, 0)), 1.55, 0.10),
    (rows(upright=(0, 0, -90), hips=(0, 40, 0), travel=(0, 0, 8)), 0.40, 0.40),
], ids=["rest along X", "begins crouching", "one frame", "Z up", "crawls"])  # fmt: skip
def test_skeletons_stand_as_they_move_and_not_as_at_rest(motion, head, foot):
    take = read_bvh(capture_files.bvh(ALONG_X, motion))
    heights = dict(zip(take.labels, take.positions[-1, :, 2], strict=True))
    assert heights["Head"] == pytest.approx(head) and heights["LeftFoot"] == heights["RightFoot"] == pytest.approx(foot)


@pytest.mark.parametrize(
    "factor, name",
    [(0.01, "meters"), (0.1, "decimeters"), (0.19, "1/0.45 inches"), (0.4, "inches"), (10.0, "millimeters")],
)
def test_bvh_in_other_units(factor, name):
    figure = ("Hips", (0, 0, 0), MOVES, [("Head", (0, 160 * factor, 0), ("Xrotation",), [])])
    take = read_bvh(capture_files.bvh(figure, [[0, 90 * factor, 0, 0]]))
    assert has_note(take, name)
    assert 1.5 < take.positions[0, 1, 2] - take.positions[0, 0, 2] < 1.8


def test_bvh_positions_of_joints_replace_the_offset_or_are_added_as_the_bone_wants_it():
    for written, tip in (((1.0, 50.0, 2.0), (1.0, 50.0, 2.0)), ((0.1, 0.0, 0.2), (0.1, 50.0, 0.2))):
        figure = ("Hips", (0, 0, 0), MOVES, [("Chest", (0, 50, 0), MOVES, [])])
        take = read_bvh(capture_files.bvh(figure, [(0, 0, 0, *written)]), up_axis="Z", unit=1.0)
        assert take.positions[0, 1] == pytest.approx(tip)


def test_bvh_several_roots_and_equal_names():
    one = capture_files.bvh(("A", (0, 0, 0), MOVES, [("B", (0, 80, 0), ("Xrotation",), [])]), []).decode()
    roots = one.split("MOTION")[0].removeprefix("HIERARCHY\n")
    content = f"HIERARCHY\n{roots}{roots}MOTION\nFrames: 1\nFrame Time: 0.04\n1 2 3 0 4 5 6 0\n"
    take = read_bvh(content.encode(), up_axis="Z", unit=1.0)
    assert take.labels == ("A", "B", "A_2", "B_2")
    assert take.positions[0] == pytest.approx(np.array([(1, 2, 3), (1, 82, 3), (4, 5, 6), (4, 85, 6)]))


@pytest.mark.parametrize(
    "text, rate",
    [
        ("0.0083333", 120.0),
        ("0.033333", 30.0),
        ("0.041667", 24.0),
        ("0.0417", 24.0),
        ("0.01", 100.0),
        (".04", 25.0),
        ("1e-2", 100.0),
        ("0.033367", 30.0 / 1.001),
        ("0.0123457", 81.0),
        ("0.0123", 1 / 0.0123),
    ],
)
def test_bvh_rates_that_were_rounded(text, rate):
    assert read_bvh(capture_files.bvh(FIGURE, moves(), frame_time=text)).rate_hz == pytest.approx(rate, rel=1e-9)


@pytest.mark.parametrize("text", ["0", "-1", "nan", "fast"])
def test_bvh_without_a_rate(text):
    take = read_bvh(capture_files.bvh(FIGURE, moves(), frame_time=text))
    assert take.rate_hz == 30.0 and has_note(take, "30 frames a second are assumed")


def test_bvh_dialects():
    plain = capture_files.bvh(FIGURE, moves())
    wanted = read_bvh(plain)
    text = plain.decode()
    one_line = " ".join(text.split("MOTION")[0].split())
    for other in (
        text.replace("\n", "\r\n"),
        text.replace("\n{", " {").replace("\t{", "{"),
        text.replace("\t", "    ").replace("Frames:", "Frames :").replace("CHANNELS", "channels"),
        text.replace("Xposition", "XPOSITION").replace("End Site", "END SITE"),
        text + "\n\n",
    ):
        take = read_bvh(other.encode())
        assert take.labels == wanted.labels and np.array_equal(take.positions, wanted.positions)
    with pytest.raises(MotionFileError, match="line 1"):
        read_bvh(one_line.encode())


def test_bvh_that_was_cut_off_gives_its_whole_frames_and_says_so():
    content = capture_files.bvh(FIGURE, moves(5))
    take = read_bvh(content[:-60])
    assert take.frames == 4 and has_note(take, "cut off", "4", "5")
    assert np.array_equal(take.positions, read_bvh(content).positions[:4])


@pytest.mark.parametrize(
    "old, new, words",
    [
        ("HIERARCHY", "HIER", "line 1: this is no BVH"),
        ("ROOT", "JOINT", "line 2: 'JOINT Hips' has no place outside"),
        ("JOINT", "ROOT", "line 6: 'ROOT Knee' has no place in joint 'Hips' .line 2."),
        ("ROOT Hips\n{", "ROOT Hips\n", r"line 4: a '\{' is missing after 'Hips'"),
        ("OFFSET 0.000000 -45.000000 0.000000", "OFFSET 1 2", "line 8: OFFSET needs three numbers"),
        ("OFFSET 0.000000 -45.000000 0.000000", "OFFSET 1 2 nan", "line 8: OFFSET needs three numbers"),
        ("OFFSET 0.000000 -45.000000 0.000000", "", r"joint 'Knee' \(line 6\) has no OFFSET"),
        ("CHANNELS 1", "CHANNELS 2", "line 9: CHANNELS .* the count"),
        ("CHANNELS 1 Xrotation", "CHANNELS 1 Wrotation", "line 9: .*Zrotation are known"),
        ("CHANNELS 1 Xrotation", "CHANNELS 2 Xrotation Xrotation", "line 9: .*each once"),
        ("CHANNELS 1 Xrotation", "CHANNELS 1 Xrotation\nCHANNELS 1 Xrotation", "line 10: .* no place in joint 'Knee'"),
        ("OFFSET 0.000000 -42.000000 0.000000", "OFFSET 0 1 2\nCHANNELS 0", "line 13: .* in joint 'Knee_end'"),
        ("}\nMOTION", "MOTION", "line 29: 'MOTION' has no place in joint 'Hips' .line 2."),
        ("}\nMOTION", "}\n}\nMOTION", r"line 30: '\}' has no place outside"),
        ("MOTION", "MOTOR", "line 30: 'MOTOR' has no place"),
        ("Frames:", "Bilder:", "'Frames: N' is missing"),
        ("Frames: 4", "Frames: -4", "'Frames: N' is missing"),
        ("Frame Time:", "Time:", "'Frame Time: SECONDS' is missing"),
        ("0.0083333\n", "0.0083333\n1 2 3\n", "line 33: it has 3 numbers where there must be 13"),
        ("0.0083333\n", "0.0083333\n" + "1 " * 14 + "\n", "line 33: it has 14 numbers"),
        ("0.0083333\n", "0.0083333\n" + "x " * 13 + "\n", "line 33: 'x' is no number"),
    ],
)
def test_damaged_bvh_is_refused_with_its_line(old, new, words):
    text = capture_files.bvh(FIGURE, moves()).decode()
    assert old in text
    with pytest.raises(MotionFileError, match=rf"^walk\.bvh.*{words}"):
        read_bvh(text.replace(old, new, 1).encode())


def test_a_real_bvh_stands_on_its_feet():
    take = read_bvh(content_of("mocap/bvh/scaled_131_01.bvh"))
    assert take.positions.shape == (995, 38, 3) and take.rate_hz == 120.0
    head, toes = (take.labels.index(name) for name in ("Head", "LeftToe"))
    above = take.positions[:, head, 2] - take.positions[:, toes, 2]
    assert above.min() > 0.5 and 1.1 < np.median(above) < 1.5


@pytest.mark.parametrize("name", ["tpose", "walk1", "dance1"])
def test_bvh_of_another_program_with_z_up_in_decimetres(name):
    take = read_bvh(content_of(f"makehuman/{name}.bvh"))
    assert has_note(take, "decimeters") and has_note(take, "Z is assumed")
    spread = take.positions[0].max(axis=0) - take.positions[0].min(axis=0)
    assert 1.4 < spread[2] < 2.2
