# SPDX-License-Identifier: GPL-3.0-or-later
"""The farm's commands: exit codes, killed tasks, the same bytes; also as engines call them, in their own processes."""

import json
import os
import shutil
import subprocess
import sys
import time

import bpy
import numpy as np
import pytest
from support import farm
from support.baking import curves
from support.farm import baked_at_once, planned, run, two_clips

#: Blender's module has no command line; so it does the same as Blender.
BY_MODULE = """
import runpy, sys, bpy
script, blend = sys.argv[1:3]
if blend:
    bpy.ops.wm.open_mainfile(filepath=blend)
runpy.run_path(script, run_name="__main__")
"""


@pytest.fixture
def command(tmp_path):
    """command(blend or None, argument, ...): how engines start the program, which lies anywhere."""
    script = shutil.copy(farm.SCRIPT, tmp_path)

    def made(blend, *arguments):
        if bpy.app.binary_path:
            words = [bpy.app.binary_path, "-b", "--factory-startup", "-noaudio", *([str(blend)] if blend else [])]
            words += ["--python-exit-code", "1", "--python", script]
        else:
            words = [sys.executable, "-c", BY_MODULE, script, str(blend or "")]
        return [*words, "--", *map(str, arguments)]

    return made


def process(words, **variables):
    environment = {**os.environ, "PATH": "/usr/bin:/bin", **variables}
    return subprocess.run(words, capture_output=True, text=True, timeout=300, env=environment)


def missing(out, capfd):
    """What `status --missing` says."""
    capfd.readouterr()
    assert run("status", "--out", out, "--missing") == 0
    return capfd.readouterr().out.splitlines()[-1]


@pytest.mark.slow
def test_a_killed_task_is_resumed_and_clips_are_merged_whatever_the_folder_is_called(
    tmp_path, part, monkeypatch, command, capfd
):
    monkeypatch.setattr(part("scene.core.whole_files"), "ABANDONED_SECONDS", -1)
    blend = two_clips(tmp_path)
    out = tmp_path / "手"
    done = process(command(blend, "plan", "--out", out, "--chunk", 20), PYTHONIOENCODING="cp1252")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "\\u624b/plan" in done.stdout or "手/plan" in done.stdout  # as it is, where Python is in UTF-8 mode
    assert (out / "plan" / "tasks.tsv").read_text().splitlines()[:4] == [
        "First\t1-20", "First\t21-40", "First\t41-60", "Second\t1-20",
    ]  # fmt: skip

    plan = ("--plan", out / "plan", "--index")
    killed = subprocess.Popen(command(None, "bake", *plan, 4), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(1.5)
    killed.kill()
    killed.wait()
    done = process(command(None, "bake", *plan, 0))
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("Time: ") == 20
    assert "openjd_progress: 100.0" in done.stdout
    assert [run("bake", *plan, index) for index in (5, 1, 2)] == [0, 0, 0]
    assert missing(out, capfd) in {"3-4", "3"}
    assert run("merge", *plan, 0) == 0
    assert process(command(None, "merge", *plan, 1)).returncode == 3
    assert [run("bake", *plan, index) for index in range(6)] == [0] * 6
    assert missing(out, capfd) == ""
    assert run("merge", *plan, 1) == 0
    for name in ("First", "Second"):
        assert (out / name / f"{name}.pc2").read_bytes() == baked_at_once(tmp_path, name), name
    assert list(out.rglob("*.tmp.*")) == []


@pytest.mark.slow
def test_done_before_is_done(tmp_path, capfd):
    two_clips(tmp_path)
    out = planned(tmp_path, "--clip", "First")
    key = json.loads((out / "plan" / "plan.json").read_text())["clips"][0]["key"]
    own = ("--clip", "First", "--out", out, "--key", key, "--frames")
    assert run("bake", *own, "1..30") == 0
    chunk = out / "First" / "chunks" / f"{key[:16]}_+000001_+000030.npz"
    stamp = chunk.stat().st_mtime_ns
    assert run("bake", *own, "1-30") == 0
    assert chunk.stat().st_mtime_ns == stamp
    assert run("bake", *own, "31-33,34,35-60") == 0
    assert run("merge", *own, "1-60") == 0
    stamp = (out / "First" / "First.pc2").stat().st_mtime_ns
    assert run("merge", *own, "1-60") == 0
    assert (out / "First" / "First.pc2").stat().st_mtime_ns == stamp
    capfd.readouterr()
    assert run("status", "--out", out) == 0
    assert "60 of 60 frames, merged" in capfd.readouterr().out


@pytest.mark.slow
def test_exit_codes(tmp_path, capfd):
    two_clips(tmp_path)
    out = planned(tmp_path, "--clip", "First")
    plan, task = ("--plan", out / "plan", "--index"), ("bake", "--out", out, "--clip", "First", "--frames")
    for wrong in (
        (), ("bake", "--frames", "x"), ("bake", *plan, 7), ("bake", "--plan", tmp_path, "--index", 0),
        (*task, "1-99"), (*task, "1-2", "--key", "other"), ("plan", "--out", out, "--clip", "Nobody"),
    ):  # fmt: skip
        assert run(*wrong) == 2, wrong
    assert run("merge", *plan, 0) == 3
    assert [run("bake", *plan, index) for index in range(3)] == [0, 0, 0]
    (damaged,) = out.rglob("*_+000021_+000040.npz")
    content = bytearray(damaged.read_bytes())
    content[300] ^= 1
    damaged.write_bytes(content)
    assert run("merge", *plan, 0) == 4
    assert missing(out, capfd) == "1"
    clip = out / "plan" / "First.npz"
    clip.write_bytes(clip.read_bytes()[:1000])
    assert run("bake", *plan, 1) == 1


@pytest.mark.slow
def test_a_changed_scene_is_another_key_and_never_mixes(tmp_path):
    two_clips(tmp_path)
    out = planned(tmp_path, "--clip", "Second")
    plan = ("--plan", out / "plan", "--index")
    assert [run("bake", *plan, index) for index in range(3)] == [0, 0, 0]
    assert run("merge", *plan, 0) == 0
    control = bpy.data.objects["Second"].meanvalue.handles["Top"].control
    curves(control)[0].keyframe_points[2].co.y += 0.5
    planned(tmp_path, "--clip", "Second")
    assert run("merge", *plan, 0) == 3
    assert [run("bake", *plan, index) for index in range(3)] == [0, 0, 0]
    assert run("merge", *plan, 0) == 0
    assert (out / "Second" / "Second.pc2").read_bytes() == baked_at_once(tmp_path, "Second")


@pytest.mark.slow
def test_clips_have_names_objects_and_ranges(tmp_path):
    two_clips(tmp_path)
    wanted = [word for text in ("Walk=First:5-9", "Run=First:20..22", "Second") for word in ("--clip", text)]
    out = planned(tmp_path, *wanted, "--frames", "1-3")
    assert (out / "plan" / "clips.tsv").read_text().splitlines() == ["Walk\t5-9", "Run\t20-22", "Second\t1-3"]
    for wrong in (("--clip", "First", "--clip", "First"), ("--clip", "A=First:1,3")):
        assert run("plan", "--out", out, *wrong) == 2


@pytest.mark.slow
def test_a_portable_plan_is_another_key_and_solved_so(tmp_path, native):
    two_clips(tmp_path)
    keys, options = [], ("--clip", "First", "--frames", "1-4")
    for more in ((), ("--portable",)):
        out = planned(tmp_path, *options, *more)
        (clip,) = json.loads((out / "plan" / "plan.json").read_text())["clips"]
        keys.append(clip["key"])
    assert keys[0] != keys[1]
    assert run("bake", "--plan", out / "plan", "--index", 0) == 0
    plan, triangles = farm.program().load_clip(out / "plan" / "First.npz", clip["sha256"])
    mesh = plan.clip.bind_input
    deformer = native.Deformer(
        mesh.rest.astype(np.float64), triangles, mesh.anchors, handles=mesh.handles, rigidity=mesh.rigidity,
        portable=True,
    )  # fmt: skip
    (chunk,) = out.rglob("*_+000001_+000004.npz")
    baked = np.load(chunk)["rows"]
    np.testing.assert_array_equal(baked, deformer.solve_sequence(plan.clip.targets).vertices)


@pytest.mark.slow
def test_a_mesh_that_bends_as_kept_poses_do_is_baked_from_its_plan(tmp_path):
    two_clips(tmp_path)
    obj = bpy.data.objects["First"]
    for frame in (10, 20):
        bpy.context.scene.frame_set(frame)
        bpy.context.view_layer.objects.active = obj
        assert bpy.ops.meanvalue.solve() == {'FINISHED'} and bpy.ops.meanvalue.keep_pose() == {'FINISHED'}
    obj.meanvalue.bend_at = 'POSES'
    out = planned(tmp_path, "--clip", "First", "--frames", "1-4")
    assert run("bake", "--plan", out / "plan", "--index", 0) == 0


# -- the files for Slurm and OpenJD; the latter run by the real program where it is installed --------------------------


CLIPS, TASKS = ("First", "Second"), 6

needs_blender = pytest.mark.skipif(not bpy.app.binary_path, reason="the bpy module has no Blender to start")


def same_as_at_once(out, tmp_path, name):
    return (out / name / f"{name}.pc2").read_bytes() == baked_at_once(tmp_path, name)


@needs_blender
@pytest.mark.slow
def test_the_scripts_for_slurm_bake_and_merge(tmp_path):
    """As Slurm starts the tasks of an array. What is asked of Slurm itself: host/test_farm_scripts.py."""
    two_clips(tmp_path)
    out = planned(tmp_path, "--chunk", 60)
    environment = {**os.environ, "PATH": "/usr/bin:/bin", "BLENDER": bpy.app.binary_path, "MEANVALUE_FARM": farm.SCRIPT}

    def code(name, task, *offset):
        command = ["bash", farm.FOLDER / f"slurm_{name}.sh", out, *offset]
        return subprocess.run(command, env={**environment, "SLURM_ARRAY_TASK_ID": str(task)}, timeout=300).returncode

    assert (code("merge", 0), code("bake", 0, "1"), code("merge", 0, "1")) == (3, 0, 0)  # one clip holds up no other
    assert same_as_at_once(out, tmp_path, "Second")


@needs_blender
@pytest.mark.slow
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
