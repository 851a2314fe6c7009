# SPDX-License-Identifier: GPL-3.0-or-later
"""other_systems.py: what pytest said there, which files are run, and that one which ends with a crash is a failure."""

import pathlib
import sys

import pytest

from blender_tests import other_systems


@pytest.mark.parametrize(
    ("said", "found"),
    [
        ("1 failed, 79 passed, 2 skipped in 39.22s", {"failed": 1, "passed": 79, "skipped": 2}),
        ("== 3 passed, 1 warning, 1 error in 61.10s (0:01:01) ==", {"passed": 3, "warning": 1, "errors": 1}),
        ("no tests ran in 0.01s", {}),
        ("1 failed assertion\nSegmentation fault", {}),
    ],
)
def test_what_pytest_said(said, found):
    assert other_systems.counts(f"first line\n{said}\n") == found


def test_files_are_named_or_all():
    one = "blender_tests/host/test_packages.py"
    assert other_systems.files_and_options("host", ["-k", "name", one]) == ([one], ["-k", "name"])
    files, options = other_systems.files_and_options("host", ["-x"])
    assert one in files and options == ["-x"]
    files, _ = other_systems.files_and_options("blender", [])
    assert {pathlib.Path(file).parent.name for file in files} == {"unit", "scenarios"}


@pytest.mark.parametrize(("program", "failed"), [("print('2 passed in 1.0s')", 0), ("import os; os._exit(139)", 1)])
def test_a_process_that_ends_early_is_a_failure(program, failed, capfd):
    assert other_systems.run_file("file", [sys.executable, "-c", program], None)["failed"] == failed
    assert ("ended with status 139" in capfd.readouterr().out) == bool(failed)


def test_paths_in_wine():
    assert other_systems.Wine(pathlib.Path("build")).path(pathlib.PurePosixPath("/a/b c")) == "Z:\\a\\b c"
