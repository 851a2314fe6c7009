# SPDX-License-Identifier: GPL-3.0-or-later
"""The files for Slurm and OpenJD; the latter run by the real program where it is installed."""

import os
import shutil
import subprocess

import bpy
import pytest
from support import farm
from support.farm import baked_at_once, planned, two_clips

CLIPS, TASKS = ("First", "Second"), 6


pytestmark = pytest.mark.skipif(not bpy.app.binary_path, reason="this is the bpy module: there is no Blender to start")


def same_as_at_once(out, tmp_path, name):
    return (out / name / f"{name}.pc2").read_bytes() == baked_at_once(tmp_path, name)


@pytest.mark.slow
def test_the_scripts_for_slurm_bake_and_merge(tmp_path):
    """As Slurm starts the tasks of an array. What is asked of Slurm itself: host/test_farm_scripts.py."""
    two_clips(tmp_path)
    out = planned(tmp_path)
    environment = {**os.environ, "PATH": "/usr/bin:/bin", "BLENDER": bpy.app.binary_path, "MEANVALUE_FARM": farm.SCRIPT}

    def code(name, task, *offset):
        command = ["bash", farm.FOLDER / f"slurm_{name}.sh", out, *offset]
        return subprocess.run(command, env={**environment, "SLURM_ARRAY_TASK_ID": str(task)}, timeout=300).returncode

    assert [code("bake", 0), code("bake", 1), code("bake", 0, "2")] == [0, 0, 0]
    assert code("merge", 0) == 0
    assert code("merge", 0, "1") == 3  # one clip's failure holds up no other
    assert same_as_at_once(out, tmp_path, "First")


def test_openjd_runs_the_template(tmp_path):
    openjd = os.environ.get("MEANVALUE_OPENJD") or shutil.which("openjd")
    if openjd is None:
        pytest.skip("openjd-cli is not installed (or name it in MEANVALUE_OPENJD)")
    template = farm.FOLDER / "openjd_template.yaml"
    environment = {**os.environ, "PATH": "/usr/bin:/bin"}
    done = subprocess.run([openjd, "check", template], capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr
    two_clips(tmp_path)
    out = planned(tmp_path)
    values = {
        "Out": out, "FarmScript": farm.SCRIPT, "Blender": bpy.app.binary_path,
        "LastTask": TASKS - 1, "LastClip": len(CLIPS) - 1,
    }  # fmt: skip
    parameters = [word for name, value in values.items() for word in ("-p", f"{name}={value}")]
    command = [openjd, "run", template, "--step", "Merge", "--run-dependencies", *parameters]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=500)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    for name in CLIPS:
        assert same_as_at_once(out, tmp_path, name)
