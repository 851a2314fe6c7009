# SPDX-License-Identifier: GPL-3.0-or-later
"""`./dev demo example` at low resolution: by the operators from a rig's animation to handles that bend as it does."""

import pytest

from blender_tests.demo.example import run
from blender_tests.demo.rig import figures

pytestmark = pytest.mark.slow


def test_examples_of_the_rig_halve_the_error_around_joints():
    figure = figures.walker(spacing=0.026)
    obj, truths, shapes, _seconds = run.carry(figure)
    assert sum(key.name.startswith("Rig Pose") for key in obj.data.shape_keys.key_blocks) == 10
    for where, (without, with_examples) in run.errors(figure, truths, shapes).items():
        assert with_examples < 0.6 * without, where
