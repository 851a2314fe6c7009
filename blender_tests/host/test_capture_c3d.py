# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/core/capture/: the samples of C3D files, and which of their points are markers."""

import numpy as np
import pytest

from addon.capture.core import c3d_file
from addon.errors import MotionFileError
from blender_tests.support import capture_files, walker
from blender_tests.support.capture_files import has_note

METRES = walker.positions()
GAPPY = walker.with_gaps(METRES, (1, 3, 7), (7, 0, 2), (7, 15, 20))
#: Half a step of the whole numbers below, in metres.
HALF_STEP = 0.0001 / 2
#: Of float32 at these sizes, in metres.
FLOAT_ERROR = 5e-7


def read_c3d(content, **options):
    return c3d_file.read(content, "take.c3d", **options)


# -- samples ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("processor", ["PC", "DEC", "SGI"])
@pytest.mark.parametrize("scale, error", [(-0.1, FLOAT_ERROR), (0.1, HALF_STEP + FLOAT_ERROR)], ids=["float", "whole"])
@pytest.mark.parametrize("analog", [0, 5])
def test_c3d_gives_back_what_was_written(processor, scale, error, analog):
    content = capture_files.c3d(
        walker.LABELS, 1000.0 * GAPPY, processor=processor, scale=scale, analog=analog, rate=120.0, first_frame=342
    )
    take = read_c3d(content)
    assert take.labels == walker.LABELS
    assert take.rate_hz == 120.0
    assert take.name == "take" and take.start_s == 341 / 120
    assert np.array_equal(np.isnan(take.positions), np.isnan(GAPPY))
    assert np.nanmax(np.abs(take.positions - GAPPY)) <= error
    assert take.left_out == {} and take.notes == ()


@pytest.mark.parametrize("value", [np.inf, -np.inf])
def test_zeros_without_a_residual_and_infinite_numbers_are_missing_too(value):
    positions = 1000.0 * METRES
    positions[4, 2] = 0.0
    positions[5, 3] = (1.0, value, 1.0)
    take = read_c3d(capture_files.c3d(walker.LABELS, positions, residuals=0.0))
    assert [tuple(place) for place in np.argwhere(~take.measured)] == [(4, 2), (5, 3)]


def test_samples_too_far_to_be_true_are_missing_and_noted():
    positions = 1000.0 * METRES
    positions[4, 2, 1] = 3e30
    take = read_c3d(capture_files.c3d(walker.LABELS, positions))
    assert [tuple(place) for place in np.argwhere(~take.measured)] == [(4, 2)]
    assert has_note(take, "1 of 160 samples", "10 km")


def test_where_most_samples_are_too_far_the_file_is_refused():
    with pytest.raises(MotionFileError, match=r"take\.c3d: .*10 km"):
        read_c3d(capture_files.c3d(walker.LABELS, 1e9 * METRES))


def test_more_frames_than_the_header_can_count():
    frames = 65540
    positions = np.zeros((frames, 1, 3)) + np.linspace(1.0, 2.0, frames)[:, None, None]
    last = {"TRIAL": {"ACTUAL_START_FIELD": [1, 0], "ACTUAL_END_FIELD": [frames - 65536, 1]}}
    for groups in (last, {}):
        take = read_c3d(capture_files.c3d(["A"], positions, unit="m", groups=groups, analog=124))
        assert take.frames == frames
        assert np.abs(take.positions - positions).max() < 1e-6
    assert has_note(take, "65535")


def test_header_and_parameters_that_disagree_are_settled_by_the_size():
    for changes in ({"header": {"points": 200}}, {"point": {"USED": 200}}, {"header": {"data_start": 40}},
                    {"point": {"DATA_START": 40}}, {"header": {"scale": 0.1}}, {"header": {"last": 9000}},
                    {"header": {"last": 0}}, {"point": {"FRAMES": 9000}}):  # fmt: skip
        take = read_c3d(capture_files.c3d(walker.LABELS, 1000.0 * METRES, analog=3, **changes))
        assert take.labels == walker.LABELS, changes
        assert np.abs(take.positions - METRES).max() < FLOAT_ERROR, changes


@pytest.mark.parametrize("point", [{"RATE": None}, {"RATE": 0.0}, {"RATE": float("nan")}])
def test_the_rate_may_stand_in_the_header_only(point):
    assert read_c3d(capture_files.c3d(walker.LABELS, METRES, unit="m", rate=250.0, point=point)).rate_hz == 250.0
    content = capture_files.c3d(walker.LABELS, METRES, unit="m", point=point, header={"rate": 0.0})
    take = read_c3d(content)
    assert take.rate_hz == 100.0 and has_note(take, "no usable rate")


def test_a_file_that_was_cut_off_gives_its_whole_frames_and_says_so():
    content = capture_files.c3d(walker.LABELS, 1000.0 * METRES)
    start = content.index(np.float32(1000.0 * METRES[0, 0, 0]).tobytes())
    take = read_c3d(content[: start + 7 * 8 * 16 + 5])
    assert take.frames == 7 and has_note(take, "cut off", "7", "20")
    assert np.abs(take.positions - METRES[:7]).max() < FLOAT_ERROR
    with pytest.raises(MotionFileError, match="20 frames of 8 points"):
        read_c3d(content[: start + 5])


# -- which points are markers ----------------------------------------------------------------------------------------


def with_outputs(names, count=None):
    """Labels and positions of the walk with further points between the markers' and after them."""
    rng = np.random.default_rng(3)
    further = rng.normal(0.0, 40.0, (len(METRES), len(names), 3))
    return (*walker.LABELS, *names), np.concatenate([1000.0 * METRES, further], axis=1)


def test_outputs_of_models_are_left_out_by_the_files_own_groups():
    kinds = {
        "ANGLES": "angles", "FORCES": "forces", "MOMENTS": "moments", "POWERS": "powers", "SCALARS": "scalars",
        "MODELED_MARKERS": "virtual points", "ODDITIES": "oddities",
    }  # fmt: skip
    labels, positions = with_outputs([f"Of {group}" for group in kinds])
    point = {group: [f"Of {group}"] for group in kinds}
    point["TYPE_GROUPS"] = ["ANGLES", "ANGLE", "ODDITIES", "ODDITY"]
    take = read_c3d(capture_files.c3d(labels, positions, point=point))
    assert take.labels == walker.LABELS
    assert np.abs(take.positions - METRES).max() < FLOAT_ERROR
    assert take.left_out == {kind: (f"Of {group}",) for group, kind in kinds.items()}


def test_axes_of_segments_are_left_out():
    """Plug-in Gait's PELO, PELA, PELL, PELP. Markers of which one is missing are no axes."""
    labels, positions = with_outputs(["PELO", "PELA", "PELL", "PELP", "TOEO", "TOEA", "TOEL"])
    take = read_c3d(capture_files.c3d(labels, positions))
    assert take.left_out == {"segment axes": ("PELO", "PELA", "PELL", "PELP")}
    assert take.labels == (*walker.LABELS, "TOEO", "TOEA", "TOEL")


@pytest.mark.parametrize(
    "name",
    ["CentreOfMass", "CenterOfMassFloor", "Anna:LHJC", "R_HJC", "V_Mid_Hip", "L.KneeJoint", "Knee Joint Centre"],
)
def test_names_that_no_marker_has_are_virtual_points(name):
    labels, positions = with_outputs([name])
    assert read_c3d(capture_files.c3d(labels, positions)).left_out == {"virtual points": (name,)}


@pytest.mark.parametrize("name", ["LKNE3", "HeadJC2", "COMB", "Joint", "LKneeJoints", "Vest_1", "Ground", "L.Wrist"])
def test_names_of_markers_are_not(name):
    labels, positions = with_outputs([name])
    assert read_c3d(capture_files.c3d(labels, positions)).labels == labels


def test_reflections_without_a_name_are_left_out_where_others_have_one():
    labels, positions = with_outputs(["*1", "*22"])
    assert read_c3d(capture_files.c3d(labels, positions)).left_out == {"unlabelled points": ("*1", "*22")}
    nameless = tuple(f"*{k}" for k in range(8))
    assert read_c3d(capture_files.c3d(nameless, 1000.0 * METRES)).labels == nameless


def test_markers_that_were_never_seen_are_left_out():
    take = read_c3d(capture_files.c3d(walker.LABELS, 1000.0 * walker.with_gaps(METRES, (2, 0, 20))))
    assert take.left_out == {"never seen": ("LASI",)}
    assert take.labels == tuple(label for label in walker.LABELS if label != "LASI")
    with pytest.raises(MotionFileError, match="no marker has a sample"):
        read_c3d(capture_files.c3d(walker.LABELS, np.full((20, 8, 3), np.nan)))


def test_where_no_named_marker_is_seen_the_unlabelled_points_are_the_markers():
    unseen = np.where(np.arange(8)[:, None] < 3, np.nan, 1000.0 * METRES)
    take = read_c3d(capture_files.c3d([*walker.LABELS[:3], *(f"*{number}" for number in range(5))], unseen))
    assert take.labels == ("*0", "*1", "*2", "*3", "*4") and has_note(take, "unlabelled points are taken")
    assert take.left_out == {"never seen": walker.LABELS[:3]}


def test_files_without_any_marker_are_refused_by_what_they_have():
    content = capture_files.c3d(["A", "B"], METRES[:, :2], point={"ANGLES": ["A"], "POWERS": ["B"]})
    with pytest.raises(MotionFileError, match=r"no marker has a sample .1 angles, 1 powers"):
        read_c3d(content)
    content = capture_files.c3d([], np.zeros((20, 0, 3)), groups={"ROTATION": {"LABELS": ["trunk", "shin", "toe"]}})
    with pytest.raises(MotionFileError, match=r"no points .only rotations of 3 segments, 'trunk', 'shin' and 'toe'"):
        read_c3d(content)


def test_labels_are_unique_and_never_empty():
    labels = ["A", "B", "A", "", "A_2", "A", "", "Point 7"]
    take = read_c3d(capture_files.c3d(labels, 1000.0 * METRES))
    assert len(set(take.labels)) == 8
    assert [take.labels[k] for k in (0, 1, 4, 7)] == ["A", "B", "A_2", "Point 7"]
    assert take.labels[2:4] == ("A_3", "Point 4")
    assert has_note(take, "4 markers had no name of their own", "'Point 7_2'")


def test_more_labels_than_one_parameter_holds():
    labels = [f"M{k}" for k in range(600)]
    positions = np.random.default_rng(1).uniform(100.0, 1000.0, (3, 600, 3))
    take = read_c3d(capture_files.c3d(labels, positions))
    assert take.labels == tuple(labels)
    short = read_c3d(capture_files.c3d(labels, positions, point={"LABELS2": None, "LABELS3": None}))
    assert short.labels[254:257] == ("M254", "Point 256", "Point 257")
