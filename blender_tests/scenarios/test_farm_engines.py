# SPDX-License-Identifier: GPL-3.0-or-later
"""The files for Slurm and OpenJD, run by the real programs where they are installed."""

import os
import shutil
import subprocess

import bpy
import pytest
from support import farm, slurm
from support.farm import baked_at_once, planned, two_clips

CLIPS, TASKS = ("First", "Second"), 6


pytestmark = pytest.mark.skipif(not bpy.app.binary_path, reason="this is the bpy module: there is no Blender to start")


def same_as_at_once(out, tmp_path, name):
    return (out / name / f"{name}.pc2").read_bytes() == baked_at_once(tmp_path, name)


def test_slurm_arrays_one_task_killed_and_submitted_again(tmp_path):
    problem = slurm.problem()
    if problem:
        pytest.skip(problem)
    two_clips(tmp_path)
    out = planned(tmp_path)
    (tmp_path / "logs").mkdir()
    bake, merge = (str(farm.FOLDER / f"slurm_{name}.sh") for name in ("bake", "merge"))
    blender = tmp_path / "blender.sh"  # the first time, task 4 is killed while Blender starts
    blender.write_text(
        f'#!/bin/bash\nif [ "$SLURM_ARRAY_TASK_ID" = 4 ] && [ ! -e {tmp_path}/killed ]; then\n'
        f'  touch {tmp_path}/killed\n  {bpy.app.binary_path} "$@" & sleep 0.2; kill -9 $!; wait $!; exit 137\nfi\n'
        f'exec {bpy.app.binary_path} "$@"\n'
    )
    blender.chmod(0o755)
    environment = {"BLENDER": str(blender), "MEANVALUE_FARM": str(farm.SCRIPT)}
    log = f"--output={tmp_path}/logs/%x_%A_%a.log"

    with slurm.running(tmp_path / "slurm") as command:
        job = command("sbatch", "--parsable", f"--array=0-{TASKS - 1}", log, bake, str(out), **environment)
        after = f"--dependency=afterany:{job}"
        command("sbatch", "--parsable", "--array=0-1", after, log, merge, str(out), **environment)
        slurm.wait_for_all(command, 240, tmp_path / "slurm")
        logs = "\n".join(path.read_text() for path in sorted((tmp_path / "logs").iterdir()))
        assert (out / "First" / "First.pc2").exists(), logs  # one clip's failure holds up no other
        assert not (out / "Second" / "Second.pc2").exists(), logs
        assert "not baked yet" in logs

        job = command("sbatch", "--parsable", f"--array=0-{TASKS - 1}", log, bake, str(out), **environment)
        after = f"--dependency=afterany:{job}"
        command("sbatch", "--parsable", "--array=0-1", after, log, merge, str(out), **environment)
        slurm.wait_for_all(command, 240, tmp_path / "slurm")
    logs = "\n".join(path.read_text() for path in sorted((tmp_path / "logs").iterdir()))
    assert logs.count("done before") >= 5
    for name in CLIPS:
        assert same_as_at_once(out, tmp_path, name), logs
    assert list(out.rglob("*.tmp.*")) == []


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
