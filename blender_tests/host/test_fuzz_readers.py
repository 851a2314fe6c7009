# SPDX-License-Identifier: GPL-3.0-or-later
"""The short lane of `./dev fuzz`: damaged files of every kind end in an error by name, or are read."""

import pytest

pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")

from blender_tests.fuzz import driver

RUNS = 300
#: Refused by their checksum, whatever is damaged. Few damaged files are none. (Chunks have bytes that say nothing.)
CHECKED = ("bundle",)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", driver.NAMES)
def test_damaged_files(name):
    run, taken = driver.fuzz(name, RUNS)
    assert run == RUNS and taken < RUNS
    assert taken < 0.05 * RUNS if name in CHECKED else taken > 0.02 * RUNS
