# SPDX-License-Identifier: GPL-3.0-or-later
"""The farm's commands as engines call them: processes of their own, exit codes, killed tasks, the same bytes."""

import hashlib
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import time

import bpy
import numpy as np
import pytest
from support import installed
from support.baking import curves
from support.farm import baked_at_once, planned, two_clips


@pytest.fixture
def script(part):
    return pathlib.Path(part("solver.session").__file__).parent / "meanvalue_farm.py"


@pytest.fixture
def farm(script, native, monkeypatch):
    """farm("status", "--out", ...): the finished process, by a plain Python; all but plan."""
    python = shutil.which("python3", path="/usr/bin:/bin") or sys.executable
    if installed.IS_EXTENSION:  # its wheel, as if installed by pip
        folders = [str(pathlib.Path(native.__file__).parent), os.environ.get("PYTHONPATH", "")]
        monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, folders)))

    def run(*arguments, **options):
        command = [python, str(script), *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, timeout=300, **options)

    if run("--help").returncode:
        pytest.skip(f"the compiled module is not for {python}")
    run.command = [python, str(script)]
    return run


@pytest.fixture
def farm_in_blender(script):
    """As farm(), in a Blender of its own with a file."""
    if not bpy.app.binary_path:
        pytest.skip("this is the bpy module: there is no Blender to start")

    def run(blend, *arguments):
        command = [bpy.app.binary_path, "-b", "--factory-startup", "-noaudio", *([str(blend)] if blend else [])]
        command += ["--python-exit-code", "1", "--python", str(script), "--", *map(str, arguments)]
        environment = {**os.environ, "PATH": "/usr/bin:/bin"}
        return subprocess.run(command, capture_output=True, text=True, timeout=300, env=environment)

    return run


def test_two_clips_in_three_chunks_one_killed_resumed_and_merged(tmp_path, part, farm, farm_in_blender):
    blend = two_clips(tmp_path)
    out = tmp_path / "out"
    done = farm_in_blender(blend, "plan", "--out", out, "--chunk", 20)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "planned 6 tasks (indices 0 to 5) of 2 clips (0 to 1)" in done.stdout
    assert (out / "plan" / "tasks.tsv").read_text().splitlines()[:4] == [
        "First\t1-20", "First\t21-40", "First\t41-60", "Second\t1-20",
    ]  # fmt: skip

    task = [*farm.command, "bake", "--plan", out / "plan", "--index", "4"]
    killed = subprocess.Popen(task, stdout=subprocess.DEVNULL)
    time.sleep(0.3)
    killed.send_signal(signal.SIGKILL)
    killed.wait()
    done = farm_in_blender(None, "bake", "--plan", out / "plan", "--index", 0)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("Time: ") == 20
    assert "openjd_progress: 100.0" in done.stdout
    for index in (5, 1, 2):
        assert farm("bake", "--plan", out / "plan", "--index", index).returncode == 0
    assert farm("status", "--out", out, "--missing").stdout.splitlines()[-1] in {"3-4", "3"}
    assert farm("merge", "--plan", out / "plan", "--index", 0).returncode == 0
    incomplete = farm("merge", "--plan", out / "plan", "--index", 1)
    assert incomplete.returncode == 3
    assert "not baked yet" in incomplete.stderr
    for index in range(6):
        assert farm("bake", "--plan", out / "plan", "--index", index).returncode == 0
    assert farm("status", "--out", out, "--missing").stdout.splitlines()[-1] == ""
    assert farm("merge", "--plan", out / "plan", "--index", 1).returncode == 0
    for name in ("First", "Second"):
        assert (out / name / f"{name}.pc2").read_bytes() == baked_at_once(tmp_path, name), name
    assert list(out.rglob("*.tmp.*")) == []


def test_killed_at_random_moments_it_goes_on_to_the_same_bytes(tmp_path, part, farm):
    two_clips(tmp_path)
    out = planned(tmp_path, part, ["First"], chunk=7)
    path, begun = out / "First" / "First.pc2", time.monotonic()
    assert farm("bake", "--plan", out / "plan", "--index", 0).returncode == 0
    seconds, chance, whole = time.monotonic() - begun, random.Random(3), baked_at_once(tmp_path, "First")
    cut_short = 0
    for attempt in range(20):
        kind = ["merge", "--plan", out / "plan", "--index", "0"]
        missing = farm("status", "--out", out, "--missing").stdout.splitlines()[-1]
        if missing:
            kind = ["bake", "--plan", out / "plan", "--index", missing.replace("-", ",").split(",")[0]]
        task = subprocess.Popen([*farm.command, *kind], stdout=subprocess.DEVNULL)
        time.sleep(seconds * chance.uniform(0.1, 1.2))
        task.send_signal(signal.SIGKILL)
        cut_short += task.wait() == -signal.SIGKILL
        assert not path.exists() or path.read_bytes() == whole, attempt
    assert cut_short
    for index in range(9):
        assert farm("bake", "--plan", out / "plan", "--index", index).returncode == 0
    assert farm("merge", "--plan", out / "plan", "--index", 0).returncode == 0
    assert path.read_bytes() == whole
    assert list(out.rglob("*.tmp.*")) == []


def test_done_before_is_done(tmp_path, part, farm):
    two_clips(tmp_path)
    out = planned(tmp_path, part, ["First"])
    key = json.loads((out / "plan" / "plan.json").read_text())["clips"][0]["key"]
    own = ("--clip", "First", "--out", out, "--key", key)
    assert farm("bake", *own, "--frames", "1..30").returncode == 0
    chunk = out / "First" / "chunks" / "+000001_+000030.pc2"
    stamp = chunk.stat().st_mtime_ns
    again = farm("bake", *own, "--frames", "1-30")
    assert again.returncode == 0
    assert "done before" in again.stdout
    assert chunk.stat().st_mtime_ns == stamp
    assert farm("bake", *own, "--frames", "31-33,34,35-60").returncode == 0
    assert farm("merge", *own, "--frames", "1-60").returncode == 0
    assert "done before" in farm("merge", *own, "--frames", "1-60").stdout
    assert "1 of 1" not in farm("status", "--out", out).stderr
    assert "60 of 60 frames, merged" in farm("status", "--out", out).stdout


def test_exit_codes(tmp_path, part, farm, farm_in_blender):
    blend = two_clips(tmp_path)
    out = planned(tmp_path, part, ["First"])
    assert farm().returncode == 2
    assert farm("bake", "--frames", "x").returncode == 2
    assert farm("bake", "--plan", out / "plan", "--index", "7").returncode == 2
    assert farm("bake", "--plan", tmp_path / "elsewhere", "--index", "0").returncode == 2
    task = ("bake", "--out", out, "--clip", "First", "--frames")
    assert farm(*task, "1-99").returncode == 2
    assert farm(*task, "1-2", "--key", "other").returncode == 2
    assert farm("merge", "--plan", out / "plan", "--index", "0").returncode == 3
    for index in range(3):
        assert farm("bake", "--plan", out / "plan", "--index", index).returncode == 0
    damaged = out / "First" / "chunks" / "+000021_+000040.pc2"
    content = bytearray(damaged.read_bytes())
    content[-1] ^= 1
    damaged.write_bytes(content)
    assert farm("merge", "--plan", out / "plan", "--index", "0").returncode == 4
    assert farm("status", "--out", out, "--missing").stdout.splitlines()[-1] == "1"
    assert farm_in_blender(blend, "plan", "--out", out, "--clip", "Nobody").returncode == 2
    bundle = out / "plan" / "First.npz"
    bundle.write_bytes(bundle.read_bytes()[:1000])
    assert farm("bake", "--plan", out / "plan", "--index", "1").returncode == 1


def test_a_changed_scene_is_another_key_and_never_mixes(tmp_path, part, farm):
    two_clips(tmp_path)
    out = planned(tmp_path, part, ["Second"])
    for index in range(3):
        assert farm("bake", "--plan", out / "plan", "--index", index).returncode == 0
    assert farm("merge", "--plan", out / "plan", "--index", 0).returncode == 0
    control = bpy.data.objects["Second"].meanvalue.handles["Top"].control
    curves(control)[0].keyframe_points[2].co.y += 0.5
    assert planned(tmp_path, part, ["Second"]) == out
    assert farm("merge", "--plan", out / "plan", "--index", 0).returncode == 3
    for index in range(3):
        assert farm("bake", "--plan", out / "plan", "--index", index).returncode == 0
    assert farm("merge", "--plan", out / "plan", "--index", 0).returncode == 0
    assert (out / "Second" / "Second.pc2").read_bytes() == baked_at_once(tmp_path, "Second")


def test_clips_have_names_objects_and_ranges(tmp_path, part):
    two_clips(tmp_path)
    planned_clips = part("baking.bridge.farm_scene").planned
    clips = planned_clips(["Walk=First:5-9", "Run=First:20..22", "Second"], "1-3")
    assert [(name, list(plan.times)) for name, plan, _ in clips] == [
        ("Walk", [5, 6, 7, 8, 9]), ("Run", [20, 21, 22]), ("Second", [1, 2, 3]),
    ]  # fmt: skip
    assert np.isfinite(clips[0][1].targets).all()
    error = part("errors").SceneError
    for wanted, words in ((["First", "First"], "one name"), (["Nobody"], "no object"), (["A=First:1,3"], "no gaps")):
        with pytest.raises(error, match=words):
            planned_clips(wanted, "1-3")


def test_a_portable_plan_is_another_key_and_solved_so(tmp_path, part, farm, farm_in_blender):
    blend = two_clips(tmp_path)
    out = tmp_path / "out"
    load = part("baking.bridge.bundle").load
    plans = {}
    for options in ((), ("--portable",)):
        assert (
            farm_in_blender(blend, "plan", "--out", out, "--clip", "First", "--frames", "1-4", *options).returncode == 0
        )
        path = out / "plan" / "First.npz"
        plans[options], triangles = load(path, hashlib.sha256(path.read_bytes()).hexdigest())
    plain, portable = plans.values()
    assert (plain.portable, portable.portable) == (False, True)
    assert plain.key != portable.key
    assert farm("bake", "--plan", out / "plan", "--index", 0).returncode == 0
    mesh = portable.bind_input
    deformer = (
        part("solver.native_loader")
        .module()
        .Deformer(
            mesh.rest.astype(np.float64),
            triangles,
            mesh.anchors,
            handles=mesh.handles,
            rigidity=mesh.rigidity,
            portable=True,
        )
    )
    chunk = out / "First" / "chunks" / "+000001_+000004.pc2"
    baked = np.frombuffer(chunk.read_bytes()[32:], np.float32).reshape(4, -1, 3)
    np.testing.assert_array_equal(baked, deformer.solve_sequence(portable.targets).vertices)
