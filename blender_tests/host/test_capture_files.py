# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/core/capture/: C3D files, and what all formats have in common. TRC and BVH: test_capture_text_files.py."""

import os
import pathlib
import sys

import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

from addon.core.capture import readers, units
from addon.errors import MotionFileError
from blender_tests.support import capture_files, walker
from blender_tests.support.mesh_files import DATA

MOCAP = DATA / "mocap"
METRES = walker.positions()
GAPPY = walker.with_gaps(METRES, (1, 3, 7), (7, 0, 2), (7, 15, 20))
#: Half a step of the whole numbers below, in metres.
HALF_STEP = 0.0001 / 2
#: Of float32 at these sizes, in metres.
FLOAT_ERROR = 5e-7


@pytest.fixture
def read(tmp_path):
    """read(bytes, suffix): a Take by way of a file."""

    def read_bytes(content, suffix=".c3d", **options):
        path = tmp_path / f"take{suffix}"
        path.write_bytes(content)
        return readers.read(path, **options)

    return read_bytes


def has_note(take, *words):
    return any(all(word in note for word in words) for note in take.notes)


def test_reading_does_not_need_blender():
    assert "bpy" not in sys.modules


# -- samples ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("processor", ["PC", "DEC", "SGI"])
@pytest.mark.parametrize("scale, error", [(-0.1, FLOAT_ERROR), (0.1, HALF_STEP + FLOAT_ERROR)], ids=["float", "whole"])
@pytest.mark.parametrize("analog", [0, 5])
def test_c3d_gives_back_what_was_written(read, processor, scale, error, analog):
    content = capture_files.c3d(
        walker.LABELS, 1000.0 * GAPPY, processor=processor, scale=scale, analog=analog, rate=120.0, first_frame=342
    )
    take = read(content)
    assert take.labels == walker.LABELS
    assert take.rate_hz == 120.0
    assert take.first_frame == 342
    assert take.name == "take"
    assert np.array_equal(np.isnan(take.positions), np.isnan(GAPPY))
    assert np.nanmax(np.abs(take.positions - GAPPY)) <= error
    assert take.left_out == {} and take.notes == ()


def test_a_take_is_not_to_be_written_to(read):
    take = read(capture_files.c3d(walker.LABELS, 1000.0 * METRES))
    with pytest.raises(ValueError):
        take.positions[0] = 0.0
    assert take.frames == len(METRES) and take.seconds == pytest.approx((len(METRES) - 1) / 100.0)


def test_gaps_are_missing_samples_and_never_zero(read):
    take = read(capture_files.c3d(walker.LABELS, 1000.0 * GAPPY))
    assert np.array_equal(take.measured, ~np.isnan(GAPPY[..., 0]))
    assert take.missing_share == pytest.approx(11 / GAPPY[..., 0].size)
    assert not (take.positions[take.measured] == 0.0).all(axis=1).any()


@pytest.mark.parametrize("value", [np.inf, -np.inf])
def test_zeros_without_a_residual_and_infinite_numbers_are_missing_too(read, value):
    positions = 1000.0 * METRES
    positions[4, 2] = 0.0
    positions[5, 3] = (1.0, value, 1.0)
    take = read(capture_files.c3d(walker.LABELS, positions, residuals=0.0))
    assert [tuple(place) for place in np.argwhere(~take.measured)] == [(4, 2), (5, 3)]


def test_samples_too_far_to_be_true_are_missing_and_noted(read):
    positions = 1000.0 * METRES
    positions[4, 2, 1] = 3e30
    take = read(capture_files.c3d(walker.LABELS, positions))
    assert [tuple(place) for place in np.argwhere(~take.measured)] == [(4, 2)]
    assert has_note(take, "1 samples", "10 km")


def test_where_most_samples_are_too_far_the_file_is_refused(read):
    with pytest.raises(MotionFileError, match=r"take\.c3d: .*10 km"):
        read(capture_files.c3d(walker.LABELS, 1e9 * METRES))


def test_more_frames_than_the_header_can_count(read):
    frames = 65540
    positions = np.zeros((frames, 1, 3)) + np.linspace(1.0, 2.0, frames)[:, None, None]
    last = {"TRIAL": {"ACTUAL_START_FIELD": [1, 0], "ACTUAL_END_FIELD": [frames - 65536, 1]}}
    for groups in (last, {}):
        take = read(capture_files.c3d(["A"], positions, unit="m", groups=groups, analog=124))
        assert take.frames == frames
        assert np.abs(take.positions - positions).max() < 1e-6
    assert has_note(take, "65535")


def test_header_and_parameters_that_disagree_are_settled_by_the_size(read):
    for changes in ({"header": {"points": 200}}, {"point": {"USED": 200}}, {"header": {"data_start": 40}},
                    {"point": {"DATA_START": 40}}, {"header": {"scale": 0.1}}, {"header": {"last": 9000}},
                    {"header": {"last": 0}}, {"point": {"FRAMES": 9000}}):  # fmt: skip
        take = read(capture_files.c3d(walker.LABELS, 1000.0 * METRES, analog=3, **changes))
        assert take.labels == walker.LABELS, changes
        assert np.abs(take.positions - METRES).max() < FLOAT_ERROR, changes


@pytest.mark.parametrize("point", [{"RATE": None}, {"RATE": 0.0}, {"RATE": float("nan")}])
def test_the_rate_may_stand_in_the_header_only(read, point):
    assert read(capture_files.c3d(walker.LABELS, METRES, unit="m", rate=250.0, point=point)).rate_hz == 250.0
    content = capture_files.c3d(walker.LABELS, METRES, unit="m", point=point, header={"rate": 0.0})
    take = read(content)
    assert take.rate_hz == 100.0 and has_note(take, "no usable rate")


def test_a_file_that_was_cut_off_gives_its_whole_frames_and_says_so(read):
    content = capture_files.c3d(walker.LABELS, 1000.0 * METRES)
    start = content.index(np.float32(1000.0 * METRES[0, 0, 0]).tobytes())
    take = read(content[: start + 7 * 8 * 16 + 5])
    assert take.frames == 7 and has_note(take, "cut off", "7", "20")
    assert np.abs(take.positions - METRES[:7]).max() < FLOAT_ERROR
    with pytest.raises(MotionFileError, match="20 frames of 8 points"):
        read(content[: start + 5])


# -- units and axes --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("unit, metres", [("mm", 0.001), ("cm", 0.01), ("m", 1.0), ("Meters", 1.0), ("in", 0.0254), (" MM ", 0.001)])
def test_positions_are_in_metres_whatever_the_unit(read, unit, metres):
    take = read(capture_files.c3d(walker.LABELS, METRES / metres, unit=unit))
    assert np.abs(take.positions - METRES).max() < FLOAT_ERROR
    assert take.notes == ()


@pytest.mark.parametrize("metres, name", [(0.001, "millimetres"), (0.01, "centimetres"), (1.0, "metres"), (0.0254, "inches")])
@pytest.mark.parametrize("unit", [None, "furlong"])
def test_an_unknown_unit_is_guessed_by_the_size_of_the_subject_and_told(read, metres, name, unit):
    take = read(capture_files.c3d(walker.LABELS, METRES / metres, unit=unit))
    assert np.abs(take.positions - METRES).max() < FLOAT_ERROR
    assert has_note(take, name, "are assumed")
    assert has_note(take, "furlong") == (unit == "furlong")


def test_a_unit_of_choice_overrules_the_file(read):
    take = read(capture_files.c3d(walker.LABELS, 100.0 * METRES, unit="mm"), unit=0.01)
    assert np.abs(take.positions - METRES).max() < FLOAT_ERROR
    for wrong in (0.0, -1.0, np.nan):
        with pytest.raises(MotionFileError, match="unit"):
            read(capture_files.c3d(walker.LABELS, METRES), unit=wrong)


def turned(up):
    """The walk as a file has it whose axis `up` is up, right-handed."""
    axis = "XYZ".index(up[-1])
    rotation = np.zeros((3, 3))
    rotation[:, axis] = (0.0, 0.0, -1.0 if up[0] == "-" else 1.0)
    rotation[0, (axis + 1) % 3] = 1.0
    rotation[:, (axis + 2) % 3] = np.cross(rotation[:, axis], rotation[:, (axis + 1) % 3])
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    return METRES @ rotation


@pytest.mark.parametrize("up", readers.UP_AXES)
def test_up_comes_from_the_file_or_by_choice_and_nothing_is_mirrored(read, up):
    across = "+X" if up[-1] != "X" else "+Y"
    by_file = read(capture_files.c3d(walker.LABELS, turned(up), unit="m", screen=(across, up if up[0] == "-" else f"+{up}")))
    by_choice = read(capture_files.c3d(walker.LABELS, turned(up), unit="m", screen=("+X", "+Y")), up_axis=up)
    for take in (by_file, by_choice):
        assert np.abs(take.positions[..., 2] - METRES[..., 2]).max() < FLOAT_ERROR
        # The same but for a turn about Z: triple products of three markers keep their sign.
        edges = take.positions[:, 1:4] - take.positions[:, :1]
        wanted = METRES[:, 1:4] - METRES[:, :1]
        assert np.linalg.det(edges) == pytest.approx(np.linalg.det(wanted), abs=1e-6)


def test_a_silent_file_is_stood_upright_by_its_markers(read):
    for up in "YZ":
        take = read(capture_files.c3d(walker.LABELS, turned(up), unit="m", screen=None))
        assert np.abs(take.positions[..., 2] - METRES[..., 2]).max() < FLOAT_ERROR
        assert has_note(take, f"{up} is assumed", "floor")


def test_where_markers_do_not_tell_the_custom_of_the_maker_does(read):
    lying = METRES * (0.2, 0.2, 0.2) + 5.0
    for company, up in (("Vicon", "Z"), ("Motion Analysis Corp.", "Y"), ("OptiTrack", "Y")):
        groups = {"MANUFACTURER": {"COMPANY": company}}
        take = read(capture_files.c3d(walker.LABELS, lying, unit="m", screen=None, groups=groups))
        assert has_note(take, f"{up} is assumed")
        assert take.positions[0, 0, 2] == pytest.approx(lying[0, 0, "XYZ".index(up)], abs=1e-5)


def test_a_file_that_contradicts_its_markers_is_followed_and_told(read):
    take = read(capture_files.c3d(walker.LABELS, METRES, unit="m", screen=("+X", "+Y")))
    assert take.positions[0, 0, 2] == pytest.approx(METRES[0, 0, 1], abs=1e-5)
    assert has_note(take, "Y is up", "Choose Z")


def test_an_axis_that_is_none_is_refused(read):
    with pytest.raises(MotionFileError, match="'W' is no axis.*-X"):
        read(capture_files.c3d(walker.LABELS, METRES), up_axis="W")


def test_every_turn_is_a_rotation():
    for up in readers.UP_AXES:
        matrix = units.turn_up(np.eye(3), up).T
        assert np.linalg.det(matrix) == 1.0
        vector = np.zeros(3)
        vector["XYZ".index(up[-1])] = -1.0 if up[0] == "-" else 1.0
        assert np.array_equal(matrix @ vector, (0.0, 0.0, 1.0))


# -- which points are markers ----------------------------------------------------------------------------------------


def with_outputs(names, count=None):
    """Labels and positions of the walk with further points between the markers' and after them."""
    rng = np.random.default_rng(3)
    further = rng.normal(0.0, 40.0, (len(METRES), len(names), 3))
    return (*walker.LABELS, *names), np.concatenate([1000.0 * METRES, further], axis=1)


def test_outputs_of_models_are_left_out_by_the_files_own_groups(read):
    labels, positions = with_outputs(["LKneeAngles", "LKneeForce", "LKneeMoment", "LKneePower", "Speed", "LKJ", "Odd"])
    point = {
        "ANGLES": ["LKneeAngles"],
        "FORCES": ["LKneeForce"],
        "MOMENTS": ["LKneeMoment"],
        "POWERS": ["LKneePower"],
        "SCALARS": ["Speed"],
        "MODELED_MARKERS": ["LKJ"],
        "ODDITIES": ["Odd"],
        "TYPE_GROUPS": ["ANGLES", "ANGLE", "ODDITIES", "ODDITY"],
    }
    take = read(capture_files.c3d(labels, positions, point=point))
    assert take.labels == walker.LABELS
    assert np.abs(take.positions - METRES).max() < FLOAT_ERROR
    assert take.left_out == {
        "angles": ("LKneeAngles",),
        "forces": ("LKneeForce",),
        "moments": ("LKneeMoment",),
        "powers": ("LKneePower",),
        "scalars": ("Speed",),
        "virtual points": ("LKJ",),
        "oddities": ("Odd",),
    }


def test_axes_of_segments_are_left_out_by_what_they_are(read):
    """Plug-in Gait's PELO, PELA, PELL, PELP: at right angles in every frame. Markers of such names are kept."""
    rng = np.random.default_rng(5)
    turn = np.linalg.qr(rng.normal(size=(len(METRES), 3, 3)))[0]
    origin = 1000.0 * METRES[:, 2:3]
    labels = (*walker.LABELS, "PELO", "PELA", "PELL", "PELP", "TOEO", "TOEA", "TOEL", "TOEP")
    positions = np.concatenate([1000.0 * METRES, origin, origin + 200.0 * turn, 900.0 * METRES[:, :4]], axis=1)
    take = read(capture_files.c3d(labels, positions))
    assert take.left_out == {"segment axes": ("PELO", "PELA", "PELL", "PELP")}
    assert take.labels == (*walker.LABELS, "TOEO", "TOEA", "TOEL", "TOEP")


@pytest.mark.parametrize("name", ["CentreOfMass", "CenterOfMassFloor", "Anna:LHJC", "R_HJC", "V_Mid_Hip", "L.KneeJoint", "Knee Joint Centre"])
def test_names_that_no_marker_has_are_virtual_points(read, name):
    labels, positions = with_outputs([name])
    assert read(capture_files.c3d(labels, positions)).left_out == {"virtual points": (name,)}


@pytest.mark.parametrize("name", ["LKNE3", "HeadJC2", "COMB", "Joint", "LKneeJointMarker", "Vest_1", "Ground", "L.Wrist"])
def test_names_of_markers_are_not(read, name):
    labels, positions = with_outputs([name])
    assert read(capture_files.c3d(labels, positions)).labels == labels


def test_reflections_without_a_name_are_left_out_where_others_have_one(read):
    labels, positions = with_outputs(["*1", "*22"])
    assert read(capture_files.c3d(labels, positions)).left_out == {"unlabelled points": ("*1", "*22")}
    nameless = tuple(f"*{k}" for k in range(8))
    assert read(capture_files.c3d(nameless, 1000.0 * METRES)).labels == nameless


def test_markers_that_were_never_seen_are_left_out(read):
    take = read(capture_files.c3d(walker.LABELS, 1000.0 * walker.with_gaps(METRES, (2, 0, 20))))
    assert take.left_out == {"never seen": ("LASI",)}
    assert take.labels == tuple(label for label in walker.LABELS if label != "LASI")
    with pytest.raises(MotionFileError, match="none of its 8 markers has a sample"):
        read(capture_files.c3d(walker.LABELS, np.full((20, 8, 3), np.nan)))


def test_points_without_a_residual_are_kept_and_told(read):
    residuals = np.ones((20, 8))
    residuals[:, 4] = 0.0
    take = read(capture_files.c3d(walker.LABELS, 1000.0 * METRES, residuals=residuals))
    assert take.labels == walker.LABELS and has_note(take, "LKNE", "computed")


def test_a_file_of_model_outputs_alone_is_refused(read):
    content = capture_files.c3d(["A", "B"], METRES[:, :2], point={"ANGLES": ["A"], "POWERS": ["B"]})
    with pytest.raises(MotionFileError, match=r"no marker.*1 angles, 1 powers"):
        read(content)


def test_labels_are_unique_and_never_empty(read):
    labels = ["A", "B", "A", "", "A_2", "A", "", "Point 7"]
    take = read(capture_files.c3d(labels, 1000.0 * METRES))
    assert len(set(take.labels)) == 8
    assert [take.labels[k] for k in (0, 1, 4, 7)] == ["A", "B", "A_2", "Point 7"]
    assert take.labels[2:4] == ("A_3", "Point 4")
    assert has_note(take, "2 markers without a name") and has_note(take, "2 markers had the name of another")


def test_more_labels_than_one_parameter_holds(read):
    labels = [f"M{k}" for k in range(600)]
    positions = np.random.default_rng(1).uniform(100.0, 1000.0, (3, 600, 3))
    take = read(capture_files.c3d(labels, positions))
    assert take.labels == tuple(labels)
    short = read(capture_files.c3d(labels, positions, point={"LABELS2": None, "LABELS3": None}))
    assert short.labels[254:257] == ("M254", "Point 256", "Point 257")


# -- what is no take -------------------------------------------------------------------------------------------------


def test_files_that_are_none_are_refused_by_name_with_a_remedy(tmp_path):
    for name, content, reason in (
        ("a.fbx", b"", r"'\.fbx' is not read.*\.c3d, \.trc, \.bvh"),
        ("plain", b"", r"is not read"),
        ("a.c3d", b"", r"no C3D file \(it has 0 bytes"),
        ("b.C3D", b"HIERARCHY" * 500, "no C3D file"),
        ("c.c3d", b"\x09\x50".ljust(2048, b"\0"), "block 9"),
        ("d.c3d", b"\x02\x50".ljust(2048, b"\0"), "number format 0"),
        ("a.trc", b"", "no TRC file"),
        ("a.bvh", b"", "no BVH file"),
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
    os.mkfifo(pipe)
    for path in (folder, pipe, tmp_path / "missing.bvh", tmp_path / ("x" * 300 + ".bvh"), "null\0.c3d"):
        with pytest.raises(MotionFileError):
            readers.read(path)


# -- real files ------------------------------------------------------------------------------------------------------


def shared(name):
    path = MOCAP / name
    if not path.is_file():
        pytest.skip(f"there is no {path}")
    return readers.read(path)


def test_pig_walk_has_35_markers_of_193_points():
    take = shared("pig-walk/PiG_Motion-FlatFoot-One.c3d")
    assert take.positions.shape == (255, 35, 3) and take.rate_hz == 100.0 and take.first_frame == 342
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
