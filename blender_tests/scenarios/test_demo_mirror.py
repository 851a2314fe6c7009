# SPDX-License-Identifier: GPL-3.0-or-later
"""`./dev demo mirror` at low resolution: the seam opens alone, and stays in its plane below the modifier."""

import numpy as np
import pytest

from blender_tests.demo import pose
from blender_tests.demo.mirror import run

pytestmark = pytest.mark.slow


def test_the_seam_stays_in_its_plane():
    obj, shoulder = run.half_figure(spacing=0.03)
    seam = np.abs(pose.positions(obj)[:, 0]) < 1e-6
    assert seam.sum() > 20
    run.raise_hand(obj, shoulder)
    alone, whole = run.both_poses(obj)
    assert np.abs(alone[seam, 0]).max() > 0.01
    assert np.abs(whole[seam, 0]).max() == 0.0
    assert np.abs(whole - pose.positions(obj)).max() > 0.2, "the hand is raised"
