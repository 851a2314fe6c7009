# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/capture/core/table_file.py: TRC files."""

import numpy as np
import pytest

from addon.capture.core import table_file
from addon.errors import MotionFileError
from blender_tests.support import capture_files, walker
from blender_tests.support.capture_files import has_note
from blender_tests.support.mesh_files import content_of

METRES = walker.positions()
#: As most TRC files: Y up. (x, y, z) of a walk with Z up is (x, z, -y) there.
Y_UP = METRES[..., [0, 2, 1]] * (1.0, 1.0, -1.0)
#: Five decimals of a millimetre.
DECIMALS = 1e-8


def read_trc(content, **options):
    return table_file.read(content, "walk.trc", **options)


def test_trc_gives_back_what_was_written_upright_in_metres():
    gaps = walker.with_gaps(1000.0 * Y_UP, (1, 3, 7), (7, 0, 2), (7, 15, 20))
    take = read_trc(capture_files.trc(walker.LABELS, gaps, rate=120.0, first_frame=31))
    assert take.labels == walker.LABELS and take.name == "walk"
    assert take.rate_hz == 120.0
    assert np.array_equal(np.isnan(take.positions), np.isnan(gaps))
    assert np.nanmax(np.abs(take.positions - METRES)) < DECIMALS
    assert has_note(take, "Y is assumed", "parts of the body")


def test_trc_with_z_up_is_seen_and_choice_overrules():
    assert np.abs(read_trc(capture_files.trc(walker.LABELS, 1000.0 * METRES)).positions - METRES).max() < DECIMALS
    take = read_trc(capture_files.trc(walker.LABELS, 1000.0 * METRES), up_axis="Y", unit=0.1)
    assert take.positions[0, 0, 2] == pytest.approx(100.0 * METRES[0, 0, 1])
    assert [note[:22] for note in take.notes] == ["By the chosen unit the"], "nobody is 168 m large"


@pytest.mark.parametrize("unit", ["", "parsec"])
def test_trc_without_a_known_unit(unit):
    take = read_trc(capture_files.trc(walker.LABELS, 1000.0 * Y_UP, keys={"Units": unit}))
    assert np.abs(take.positions - METRES).max() < DECIMALS
    assert has_note(take, f"'{unit}'" if unit else "names no unit", "millimeters are assumed")


def test_trc_rate_by_the_times_where_the_header_has_none():
    for rate in ("0", "nan", "fast"):
        take = read_trc(capture_files.trc(walker.LABELS, 1000.0 * Y_UP, keys={"DataRate": rate, "CameraRate": rate}))
        assert take.rate_hz == pytest.approx(100.0)


#: The walk with samples missing, and the same as several programs write it.
GAPPY = capture_files.trc(walker.LABELS, walker.with_gaps(1000.0 * Y_UP, (7, 2, 5))).decode()


def with_rows(change, begin=6, end=None):
    lines = GAPPY.split("\n")
    return "\n".join([*lines[:begin], *map(change, lines[begin:end]), *(lines[end:] if end else ())])


DIALECTS = {
    "windows": GAPPY.replace("\n", "\r\n"),
    "old mac": GAPPY.replace("\n", "\r"),
    "with a byte order mark": "\ufeff" + GAPPY,
    "no blank line": GAPPY.replace("\n\n", "\n", 1),
    "trailing tabs": with_rows(lambda line: line and line + "\t\t"),
    "two tabs between values": with_rows(lambda line: line.replace("\t", "\t\t"), 2, 3),
    "blanks at the end dropped": with_rows(lambda line: line.rstrip("\t")),
    "names without empty cells": GAPPY.replace("\t\t\t".join(walker.LABELS), "\t".join(walker.LABELS)),
    "nan for missing": with_rows(lambda line: line.replace("\t\t\t", "\tnan\tNaN\tnan")),
    "spaces for missing": with_rows(lambda line: line.replace("\t\t\t", "\t \t  \t ")),
    "zeros for missing": with_rows(lambda line: line.replace("\t\t\t", "\t0.0\t0.0\t0.0")),
}


@pytest.mark.parametrize("program", [*DIALECTS, "utf-16"])
def test_trc_dialects(program):
    take = read_trc(DIALECTS[program].encode() if program in DIALECTS else GAPPY.encode(program))
    assert program == "utf-16" or DIALECTS[program] != GAPPY
    assert take.labels == walker.LABELS and not has_note(take, "unit")
    assert [tuple(place) for place in np.argwhere(~take.measured)] == [(2, 7), (3, 7), (4, 7)]
    assert np.nanmax(np.abs(take.positions - METRES)) < DECIMALS


def test_trc_with_spaces_for_tabs():
    content = capture_files.trc(walker.LABELS, 1000.0 * Y_UP).replace(b"\t\t\t", b" ").replace(b"\t", b" ")
    take = read_trc(content)
    assert take.labels == walker.LABELS
    assert np.abs(take.positions - METRES).max() < DECIMALS


def test_trc_markers_without_names_get_numbers():
    labels = ["A", "", "C", "A", "", "F", "G", ""]
    take = read_trc(capture_files.trc(labels, 1000.0 * Y_UP))
    assert take.labels == ("A", "Point 2", "C", "A_2", "Point 5", "F", "G", "Point 8")


def test_trc_rows_with_more_columns_than_names():
    content = capture_files.trc(walker.LABELS, 1000.0 * Y_UP).decode()
    names = "\t\t\t".join(walker.LABELS[:6])
    lines = ["Frame#\tTime\t" + names if line.startswith("Frame#") else line for line in content.split("\n")]
    take = read_trc("\n".join(lines).replace("NumMarkers", "Markers").encode())
    assert take.labels == (*walker.LABELS[:6], "Point 7", "Point 8") and has_note(take, "more columns", "2 points")
    assert np.abs(take.positions - METRES).max() < DECIMALS


def test_trc_points_without_names_whose_number_differs_from_row_to_row():
    lines = capture_files.trc([""] * 4, 1000.0 * METRES[:, :4, [1, 2, 0]], keys={"NumMarkers": 0}).decode().split("\n")
    lines[3:5] = ["Frame#\tTime\t", "\t\t"]
    lines[6:-1] = ["\t".join(line.split("\t")[: 2 + 3 * (k % 5)]) for k, line in enumerate(lines[6:-1])]
    take = read_trc("\n".join(lines).encode())
    assert take.labels == ("Point 1", "Point 2", "Point 3", "Point 4")
    assert np.array_equal(take.measured, np.arange(20)[:, None] % 5 > np.arange(4))
    assert np.nanmax(np.abs(take.positions[..., 2] - METRES[:, :4, 2])) < 1e-6


def test_trc_tells_when_it_starts_in_its_recording():
    for begin, start in ((0.5, 0.5), (-1.0, 0.0), (36000.0, 0.0), (np.nan, 0.0), (1e300, 0.0)):
        assert read_trc(capture_files.trc(walker.LABELS, 1000.0 * METRES, begin=begin)).start_s == start


def test_trc_that_was_cut_off_gives_its_whole_rows_and_says_so():
    content = capture_files.trc(walker.LABELS, 1000.0 * Y_UP)
    take = read_trc(content[: content.index(b"\n8\t") + 30])
    assert take.frames == 7 and has_note(take, "cut off", "7", "20")
    assert np.abs(take.positions - METRES[:7]).max() < DECIMALS


@pytest.mark.parametrize(
    "change, words",
    [
        (lambda text: "\n".join(text.split("\n")[:2]), "line 2: neither the header nor a row has"),
        (lambda text: "\n".join(["\t".join(line.split("\t")[:2]) for line in text.split("\n")]), "nor a row has"),
        (lambda text: "\n".join(text.split("\n")[:6]), "line 5: neither the header nor a row has"),
        (lambda text: text.replace("\n3\t", "\ndrei\t", 1), "line 9: 'drei' is no time"),
        (lambda text: text.replace("\n3\t0.02000\t", "\n3\t0.02000\tdrei", 1), "line 9: 'drei.*' is no number"),
        (lambda text: text.replace("\n3\t", "\n3\t0\t0\t", 1), "line 9: it has 28 numbers where there must be 26"),
    ],
)
def test_damaged_trc_is_refused_with_its_line(change, words):
    with pytest.raises(MotionFileError, match=rf"^walk\.trc.*({words})"):
        read_trc(change(capture_files.trc(walker.LABELS, 1000.0 * Y_UP).decode()).encode())


def test_rajagopal_has_41_markers_and_computed_points_are_left_out():
    take = read_trc(content_of("mocap/rajagopal/motion_capture_walk.trc"))
    assert take.positions.shape == (238, 41, 3) and take.rate_hz == 100.0 and not np.isnan(take.positions).any()
    assert 0.0 < take.positions[..., 2].min() < 0.1 and 1.4 < take.positions[..., 2].max() < 1.7
    assert np.ptp(take.positions[:, 0, 0]) > 2.0  # walks along X
    static = read_trc(content_of("mocap/rajagopal/static_walk_1.trc"))
    assert set(take.labels) <= set(static.labels)
    assert len(static.labels) == 47 and len(static.left_out["virtual points"]) == 17
