# SPDX-License-Identifier: GPL-3.0-or-later
"""packaging/farm: what slurm_submit.sh asks of Slurm, told by programs that only write down how they were called."""

import os
import pathlib
import subprocess
import sys

import pytest
from fuzz.cache_files import FARM

from addon import errors

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "packaging" / "farm"
SCRIPT = FOLDER / "slurm_submit.sh"

SCONTROL = """#!/bin/bash
echo "MaxArraySize            = {size}"
"""
BLENDER = """#!/bin/bash
echo "Blender 0"
echo "meanvalue: Mean-Value Deform farm: status"
echo "{missing}"
"""
SBATCH = """#!/bin/bash
[ ! -e {folder}/broken ] || exit 1
echo "$@" >>{folder}/calls
echo "$(wc -l <{folder}/calls);cluster"
"""


def submit(folder, missing, clips, size, *options):
    """(exit code, [(script, {index}, {option: value}, offset)]) with programs of the test's own."""
    if sys.platform == "win32":
        pytest.skip("Slurm's scripts are for Linux")
    (folder / "plan").mkdir(exist_ok=True)
    (folder / "plan" / "clips.tsv").write_text("".join(f"clip{number}\t1-10\n" for number in range(clips)))
    for name, text in (("scontrol", SCONTROL), ("blender", BLENDER), ("sbatch", SBATCH)):
        (folder / name).write_text(text.format(size=size, missing=missing, folder=folder))
        (folder / name).chmod(0o755)
    calls = folder / "calls"
    calls.unlink(missing_ok=True)
    environment = {**os.environ, "PATH": f"{folder}:/usr/bin:/bin"}
    run = subprocess.run(["bash", str(SCRIPT), str(folder), *options], env=environment, capture_output=True, text=True)
    lines = calls.read_text().splitlines() if calls.exists() else []
    return run.returncode, [read_call(line) for line in lines]


def read_call(line):
    words = line.split()
    options = dict(word[2:].partition("=")[::2] for word in words if word.startswith("--"))
    script, _out, offset = (word for word in words if not word.startswith("--"))
    indices = {int(index) for index in options.pop("array").split(",")}
    return pathlib.Path(script).name, indices, options, int(offset)


@pytest.mark.parametrize(("missing", "wanted"), [
    ("0-2499", set(range(2500))),
    ("3,998-1003,2001", {3, 2001, *range(998, 1004)}),
    ("0", {0}),
])  # fmt: skip
def test_arrays_are_no_longer_than_slurm_takes_and_together_all_that_is_left(tmp_path, missing, wanted):
    code, calls = submit(tmp_path, missing, 3, 1001, "--cpus-per-task=8")
    assert code == 0
    bakes = [call for call in calls if call[0] == "slurm_bake.sh"]
    submitted = [offset + index for _, indices, _, offset in bakes for index in indices]
    assert sorted(submitted) == sorted(wanted)
    assert all(max(indices) < 1001 for _, indices, _, _ in calls)
    assert all(options["cpus-per-task"] == "8" for _, _, options, _ in calls)
    (merge,) = [call for call in calls if call[0] == "slurm_merge.sh"]
    assert merge[1] == {0, 1, 2}
    assert merge[2]["dependency"] == "afterany:" + ":".join(str(number + 1) for number in range(len(bakes)))


def test_many_clips_are_merged_in_parts(tmp_path):
    code, calls = submit(tmp_path, "0-4", 25, 10)
    assert code == 0
    merged = [offset + index for script, indices, _, offset in calls if "merge" in script for index in indices]
    assert sorted(merged) == list(range(25))
    assert all(max(indices) < 10 for _, indices, _, _ in calls)


def test_where_nothing_is_left_only_the_merges_are_submitted(tmp_path):
    code, calls = submit(tmp_path, "", 2, 1001)
    assert code == 0
    assert [(script, sorted(indices)) for script, indices, _, _ in calls] == [("slurm_merge.sh", [0, 1])]
    assert "dependency" not in calls[0][2]


def test_a_submission_that_fails_ends_the_script(tmp_path):
    (tmp_path / "broken").touch()
    assert submit(tmp_path, "0-4", 1, 1001)[0] != 0


@pytest.mark.parametrize(
    ("text", "frames"),
    [
        ("7", [7]),
        ("1-4", [1, 2, 3, 4]),
        ("7-7", [7]),
        ("41,42", [41, 42]),
        ("1-3,10,11", [1, 2, 3, 10, 11]),
        ("1..4", [1, 2, 3, 4]),
        ("-5-2", list(range(-5, 3))),
        ("-5--3", [-5, -4, -3]),
        ("-5..-3", [-5, -4, -3]),
        (" 3 , 1 - 2, 2", [1, 2, 3]),
    ],
)
def test_lists_of_frames(text, frames):
    assert FARM.parse(text) == frames
    assert FARM.parse(FARM.spelled(frames)) == frames


@pytest.mark.parametrize("text", ["", "a", "1-", "1,,2", "1.5", "4-1", "1-2-3", "1-99999999999"])
def test_what_is_no_list_of_frames(text):
    with pytest.raises(errors.SceneError, match="Write"):
        FARM.parse(text)
