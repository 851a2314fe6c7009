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
