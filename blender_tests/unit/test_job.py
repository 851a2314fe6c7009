# SPDX-License-Identifier: GPL-3.0-or-later
"""Jobs: steps on the main thread, the solver beside it, and never a thread of Python's."""

import ast
import pathlib
import threading
import time

import pytest
from support import handles, tasks


@pytest.fixture
def job(part):
    return part("solver.job")


def test_no_thread_of_pythons_runs_while_the_solver_works(part, job):
    """Blender 3.4 crashes where one does: decision 0009."""
    obj, _control = handles.tube(live=False)
    prepared = part("posing.bridge.scene_input").Posing(obj, is_checked=False)
    before = threading.active_count()
    running = job.Job(prepared.work)
    most = before
    while not running.is_finished:
        most = max(most, threading.active_count())
    assert most == before
    running.result()
    assert prepared.binding is not None


def test_it_goes_on_when_it_is_looked_at(job):
    done = []

    def work(_execution):
        yield tasks.Until(lambda: "first" in done)
        done.append("between")
        yield tasks.Until(lambda: "second" in done)
        return "result"

    running = job.Job(work)
    assert not running.is_finished
    done.append("first")
    assert not running.is_finished and done == ["first", "between"]
    assert running.wait(0.01) is False
    done.append("second")
    assert running.wait() and running.result() == "result"


def test_work_without_steps_is_finished_at_once(job):
    def work(_execution):
        return 3
        yield

    assert job.Job(work).is_finished and job.Job(work).result() == 3


@pytest.mark.parametrize("steps_before", [0, 1])
def test_errors_come_with_the_result(job, steps_before):
    def work(_execution):
        for _ in range(steps_before):
            yield tasks.Until(lambda: True)
        raise ValueError("out of order")

    running = job.Job(work)
    assert running.is_finished
    with pytest.raises(ValueError, match="out of order"):
        running.result()


def test_cancel_ends_it_soon(part, job):
    obj, _control = handles.tube(live=False)
    prepared = part("posing.bridge.scene_input").Posing(obj, is_checked=False)

    def work(execution):  # so small a mesh may be bound before it is cancelled
        yield tasks.Until(lambda: execution.cancelled)
        return (yield from prepared.work(execution))

    running = job.Job(work)
    running.cancel()
    started = time.monotonic()
    job.cancel_all()
    assert running.is_finished and time.monotonic() - started < 5.0
    assert running.is_cancelled
    with pytest.raises(part("errors").CancelledError):
        running.result()


def test_the_add_on_starts_no_threads(part):
    folder = pathlib.Path(part("solver.job").__file__).parents[1]
    sources = list(folder.rglob("*.py"))
    assert sources
    for path in sources:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [name.name for name in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom):
                names.append(node.module or "")
            for name in names:
                assert name.split(".")[0] not in {"threading", "_thread", "concurrent", "multiprocessing"}, path
