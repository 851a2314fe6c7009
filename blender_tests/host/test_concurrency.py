# SPDX-License-Identifier: GPL-3.0-or-later
"""The module used from several threads at once, and in a process that was forked: the same bits as a run alone."""

import json
import os
import pathlib
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

meanvalue = pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")

from blender_tests.support import stress  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]

pytestmark = pytest.mark.slow


def run(code_or_file, *arguments, timeout):
    """In a process of its own, since what goes wrong may end it or never end."""
    command = [sys.executable, *(["-c", code_or_file] if "\n" in code_or_file else [code_or_file]), *arguments]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in (str(ROOT), *sys.path) if path)}
    return subprocess.run(command, capture_output=True, text=True, timeout=timeout, cwd=ROOT, env=environment)


def test_many_threads_on_deformers_of_their_own_and_of_all_get_the_bits_of_a_run_alone():
    ended = run(stress.__file__, "--threads", "2", "4", "6", "--rounds", "120", "--seconds", "9", timeout=300)
    assert (ended.returncode, ended.stderr) == (0, "")
    reports = [json.loads(line) for line in ended.stdout.splitlines()]
    assert [report["threads"] for report in reports] == [2, 4, 6]
    for report in reports:
        assert report["rounds"] >= report["threads"]
        assert report["wrong"] == []


#: From 3.12 on Python warns of every fork beside threads, without knowing what these do.
FORKED = """
import os, sys, threading, time, warnings
import numpy as np, meanvalue
from blender_tests.support import stress

warnings.filterwarnings("ignore", ".*use of fork", DeprecationWarning)
one = stress.case("bar", *stress.bar(4000))
deformer, other = one.bind(threads=2), one.bind(threads=2)
expected = deformer.solve(one.targets[0]).vertices

{before}

child = os.fork()
if child == 0:
    try:
        {inside}
        assert np.array_equal(deformer.solve(one.targets[0]).vertices, expected)
        assert np.array_equal(one.bind(threads=2).solve(one.targets[0]).vertices, expected)
        print("child is right")
    except BaseException as error:
        print("child:", repr(error))
    sys.exit()
until = time.monotonic() + 60
while os.waitpid(child, os.WNOHANG) == (0, 0):
    if time.monotonic() > until:
        os.kill(child, 9)
        sys.exit("the child hangs")
    time.sleep(0.01)
{after}
assert np.array_equal(deformer.solve(one.targets[0]).vertices, expected)
print("parent is right")
"""
BUSY = """
def keep_solving():
    while busy:
        other.solve(one.targets[1])
busy = True
thread = threading.Thread(target=keep_solving)
thread.start()
time.sleep(0.05)
"""
ABANDONED = """
execution = meanvalue.Execution()
bind = one.start_bind(execution=execution)
execution.cancel()
try:
    bind.result()
except meanvalue.Cancelled:
    pass
"""
RUNNING = """
execution = meanvalue.Execution()
task = other.start_solve(one.targets[1], tolerance=1e-300, max_iterations=1000000, execution=execution)
while execution.stage != "solve":
    pass
"""
FAILS = """
        try:
            {call}
            print("it gave something")
        except meanvalue.SolverFailure as error:
            assert "forked" in str(error)
"""
FORKS = {
    "after a solve": ("", "", ""),
    "while a thread solves": (BUSY, "", "busy = False; thread.join()"),
    "after a cancel left work behind": (ABANDONED, "", ""),
    "under a task": (RUNNING, FAILS.format(call="task.result()").strip(), "task.result()"),
    "under a task, on its deformer": (
        RUNNING,
        "assert np.array_equal(other.solve(one.targets[0]).vertices, expected)",
        "execution.cancel()",
    ),
}


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
@pytest.mark.parametrize("state", FORKS)
def test_a_forked_process_binds_and_solves(state):
    before, inside, after = FORKS[state]
    ended = run(FORKED.format(before=before, inside=inside or "pass", after=after), timeout=120)
    assert ended.stderr == ""
    assert sorted(ended.stdout.splitlines()) == ["child is right", "parent is right"]
    assert ended.returncode == 0


LONG_CALLS = {
    "bind": lambda mesh: meanvalue.Deformer(*mesh, [0, 9000]),
    "task": lambda mesh: meanvalue.start_bind(*mesh, [0, 9000]).wait(),
    "clip": lambda mesh: meanvalue.Deformer(mesh[0], mesh[1][:9999], [0, 9]).solve_sequence(np.ones((9999, 2, 3))),
    "encode": lambda mesh: [meanvalue.encode(*mesh) for _ in range(20)],
    "surface": lambda mesh: meanvalue.Surface(*mesh).nearest(np.tile(mesh[0], (40, 1))),
    "baseline": lambda mesh: pytest.importorskip("meanvalue.baselines").pyramid(*mesh, [0], mesh[0][:1], sweeps=10**6),
}


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no such timer")
@pytest.mark.parametrize("call", LONG_CALLS)
def test_ctrl_c_ends_every_call_that_waits(call):
    mesh = stress.bar(200000)
    begun, raised = time.monotonic(), signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, 0.1)
    try:
        with pytest.raises(KeyboardInterrupt):
            LONG_CALLS[call](mesh)
        assert time.monotonic() - begun < 0.1 + 0.2 + 0.5, "0.2 s, and half a second where the machine is busy"
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, raised)
