# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/core/capture: how well gaps are filled, by hiding what was measured; without Blender."""

import pathlib
import sys

import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

from addon.core.capture import readers
from addon.core.capture.checks import InvalidMotionError
from addon.core.capture.error_report import leave_one_out
from blender_tests.support import mesh_files, walking_figure


def test_a_rigid_body_is_filled_exactly():
    rng = np.random.default_rng(1)
    turns = walking_figure.turn_z(np.linspace(0, 3, 150)) @ walking_figure.turn_x(np.linspace(0, 2, 150))
    path = np.einsum("fij,mj->fmi", turns, rng.standard_normal((6, 3)))
    report = leave_one_out(path)
    assert report.largest.max() < 1e-9
    assert np.array_equal(report.filled, np.ones(6))


def test_a_walk_is_filled_to_centimetres_and_the_words_name_the_worst():
    walk = walking_figure.take(260, noise=0.0005)
    report = leave_one_out(walk.positions)
    assert np.sqrt((report.rms**2).mean()) < 0.01
    worst = walk.labels[int(np.argmax(report.rms))]
    assert worst in report.words(walk.labels)
    assert "20 samples" in report.words(walk.labels)


def test_markers_that_are_hardly_seen_tell_nothing():
    walk = walking_figure.take(100)
    walk.positions[::7, 3] = np.nan
    report = leave_one_out(walk.positions)
    assert np.isnan(report.rms[3]) and not np.isnan(np.delete(report.rms, 3)).any()
    assert "Nothing" in leave_one_out(walk.positions[:30]).words(walk.labels)
    with pytest.raises(InvalidMotionError, match="0 samples"):
        leave_one_out(walk.positions, gap=0)


def test_leaving_one_marker_out_of_a_real_walk(capsys):
    path = mesh_files.DATA / "mocap" / "pig-walk" / "PiG_Motion-FlatFoot-One.c3d"
    if not path.exists():
        pytest.skip(f"no {path.name} in {path.parent}")
    take = readers.read(path)
    report = leave_one_out(take.positions)
    with capsys.disabled():
        print(f"\npig-walk: {report.words(take.labels)}")
    assert np.sqrt(np.nanmean(report.rms**2)) < 0.015
    assert np.nanmin(report.filled) > 0.99
