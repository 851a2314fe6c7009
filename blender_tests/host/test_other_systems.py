# SPDX-License-Identifier: GPL-3.0-or-later
"""other_systems.py: tests that end with a crash have failed."""

import sys

import pytest

from blender_tests import other_systems


@pytest.mark.parametrize(("program", "failed"), [("print('2 passed in 1.0s')", 0), ("import os; os._exit(139)", 1)])
def test_a_process_that_ends_early_is_a_failure(program, failed, capfd):
    assert other_systems.run_file("file", [sys.executable, "-c", program], None)["failed"] == failed
    assert ("ended with status 139" in capfd.readouterr().out) == bool(failed)
