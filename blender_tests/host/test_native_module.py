# SPDX-License-Identifier: GPL-3.0-or-later
"""The compiled module as Python sees it: types, shapes, errors, threads. The mathematics is tested in C++."""

import gc
import subprocess
import sys
import time

import numpy as np
import pytest

meanvalue = pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")

from blender_tests.support.native_calls import (  # noqa: E402
    ENDS,
    TRIANGLES,
    VERTICES,
    bent_targets,
    cancelled_while_solving,
    tube,
)


def test_encoding_arrays_have_the_documented_shapes_and_are_read_only():
    encoding = meanvalue.encode(VERTICES, TRIANGLES)
    half_edges = encoding.ring_offsets[-1]
    assert encoding.vertex_count == len(VERTICES)
    assert encoding.ring_offsets.shape == (len(VERTICES) + 1,)
    assert encoding.ring.shape == encoding.weights.shape == encoding.cotangents.shape == (half_edges,)
    assert (encoding.ring_offsets.dtype, encoding.ring.dtype) == (np.int32, np.int32)
    for array in (encoding.ring, encoding.weights, encoding.cotangents, encoding.guarded):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0


def test_deformer_meets_its_anchors_and_reports():
    deformer = meanvalue.Deformer(VERTICES, TRIANGLES, ENDS, method="full")
    solution = deformer.solve(bent_targets())
    assert np.array_equal(solution.vertices[ENDS], bent_targets())
    assert solution.converged and solution.iterations > 0
    assert solution.energies[0] == solution.initial_energy and solution.energies[-1] == solution.energy
    assert (np.diff(solution.energies) <= 0).all()
    assert solution.timings["total"] >= solution.timings["factor"] > 0
    report = deformer.report
    assert (report.vertex_count, report.anchor_count, report.free_count) == (180, 24, 156)
    assert [(part.vertex_count, part.undetermined) for part in report.components] == [(180, 0)]
    assert set(report.timings) == {"encode", "order", "analyse", "total"}
    assert report.bytes > 0


def solved(solve_options=None, **options):
    return meanvalue.Deformer(VERTICES, TRIANGLES, ENDS, **options).solve(bent_targets(), **(solve_options or {}))


def test_the_default_is_the_fast_method_with_rigidity_and_its_own_tolerance():
    vertices = solved().vertices
    assert np.array_equal(vertices, solved(method="fast", handles=None, rigidity=None).vertices)
    assert np.array_equal(vertices, solved({"tolerance": None}).vertices)
    assert np.array_equal(vertices, solved({"tolerance": 1e-4}).vertices)
    assert not np.array_equal(vertices, solved({"tolerance": 1e-7}).vertices)
    for method in ("paper", "full"):
        assert not np.allclose(vertices, solved(method=method).vertices, atol=1e-3)
    assert np.array_equal(solved(method="full").vertices, solved({"tolerance": 1e-6}, method="full").vertices)


def test_solution_vertices_are_read_only_and_outlive_the_solution():
    vertices = meanvalue.Deformer(VERTICES, TRIANGLES, ENDS).solve(bent_targets()).vertices
    with pytest.raises(ValueError, match="read-only"):
        vertices[0] = 0.0
    junk = [np.ones(vertices.shape) for _ in range(100)]
    assert np.array_equal(vertices[ENDS], bent_targets()) and len(junk) == 100


#: Types and shapes of arrays: test_array_arguments.py. Numbers that make no sense: C++.
@pytest.mark.parametrize(
    ("action", "text"),
    [
        (lambda: meanvalue.encode(VERTICES, TRIANGLES[:, :2]), r"triangulate\(\)"),
        (lambda: meanvalue.encode(VERTICES, TRIANGLES).predict(VERTICES[:5]), "5 rows"),
        (lambda: meanvalue.Deformer(VERTICES, TRIANGLES, [0], threads=-1), "threads is -1"),
        (lambda: meanvalue.Deformer(VERTICES, TRIANGLES, [0, 1, 2], handles=[0, 1]), "handles has 2 numbers"),
        (lambda: meanvalue.Deformer(VERTICES, TRIANGLES, [0, 1], handles=[0, -2]), r"handles\[1\] is -2"),
        (lambda: meanvalue.Deformer(VERTICES, TRIANGLES, [0], rigidity=-1), "rigidity is -1"),
        (lambda: meanvalue.Deformer(VERTICES, TRIANGLES, [0], rigidity=np.nan), "rigidity is nan"),
        (lambda: meanvalue.Deformer(VERTICES, TRIANGLES, [0], rigidity=np.inf), "rigidity is inf"),
        (lambda: meanvalue.Deformer(VERTICES, TRIANGLES, [0], rigidity=2, method="paper"), "rigidity is 2"),
        (lambda: meanvalue.Deformer(VERTICES, TRIANGLES, ENDS).solve(VERTICES[:3]), "targets has 3 rows"),
        (lambda: solved(strengths=[]), "strengths is empty"),
        (lambda: solved(method="quick"), "method is 'quick'"),
        (lambda: solved(loose="fall"), "loose is 'fall'"),
    ],
)
def test_bad_input_is_refused_by_name(action, text):
    with pytest.raises(meanvalue.InvalidInput, match=text):
        action()


CANCEL_AND_EXIT = """
import sys, threading
sys.path[:0] = {path!r}
import meanvalue
from blender_tests.support.native_calls import tube
vertices, triangles = tube(160, 100)
anchors = [0, 50, 15999, 15930]
execution = meanvalue.Execution()
deformer = meanvalue.Deformer(vertices, triangles, anchors)
threading.Timer({delay}, execution.cancel).start()
try:
    while True:  # until the cancel comes, on a machine of whatever speed
        deformer.solve(vertices[anchors] * [1, 2, 1], execution=execution)
except meanvalue.Cancelled:
    print("cancelled")
"""


@pytest.mark.slow
@pytest.mark.parametrize("delay", [0.05, 0.4])
def test_a_process_ends_cleanly_after_a_cancel(delay):
    code = CANCEL_AND_EXIT.format(path=sys.path, delay=delay)
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert (result.returncode, result.stdout.strip(), result.stderr) == (0, "cancelled", "")


@pytest.mark.slow
def test_the_interpreter_runs_while_solving_and_a_cancel_ends_it():
    vertices, triangles = tube(150, 120)
    anchors = np.r_[0:150, len(vertices) - 150 : len(vertices)]
    targets = vertices[anchors] + np.where(anchors[:, None] < 150, 0.0, [[20.0, 5.0, -10.0]])
    deformer = meanvalue.Deformer(vertices, triangles, anchors)
    assert cancelled_while_solving(lambda execution: deformer.solve(targets, execution=execution))
    # The deformer is usable afterwards, and nothing of the cancelled solve is left in it.
    again = deformer.solve(targets, max_iterations=1)
    fresh = meanvalue.Deformer(vertices, triangles, anchors).solve(targets, max_iterations=1)
    assert np.array_equal(again.vertices, fresh.vertices)


# -- beside the interpreter --------------------------------------------------------------------------------------------


def test_tasks_give_what_the_calls_give():
    arrays = VERTICES, TRIANGLES, ENDS
    targets = bent_targets()
    bound = meanvalue.start_bind(*arrays)
    deformer = bound.result()
    assert bound.finished and bound.result() is deformer and isinstance(deformer, meanvalue.Deformer)
    task = deformer.start_solve(targets)
    assert task.wait() is True and task.wait(0.0) is True
    now = meanvalue.Deformer(*arrays).solve(targets)
    assert np.array_equal(task.result().vertices, now.vertices)
    assert task.result() is task.result()


def test_a_task_owns_its_arrays_and_its_deformer():
    vertices, targets = VERTICES.copy(), bent_targets()
    expected = meanvalue.Deformer(vertices, TRIANGLES, ENDS).solve(targets).vertices
    bound = meanvalue.start_bind(vertices, TRIANGLES, ENDS)
    vertices[:] = np.nan
    task = bound.result().start_solve(targets)
    del bound
    targets[:] = np.nan
    gc.collect()
    assert np.array_equal(task.result().vertices, expected)


def test_a_drag_goes_on_from_its_last_answer():
    targets = bent_targets()
    deformer = meanvalue.Deformer(VERTICES, TRIANGLES, ENDS)
    steps = [VERTICES[ENDS] + share * (targets - VERTICES[ENDS]) for share in (0.5, 0.75, 1.0)]
    with deformer.drag() as drag:
        shapes = [drag.solve(step).vertices for step in steps]
    assert np.array_equal(shapes[0], deformer.solve(steps[0]).vertices)
    with deformer.drag(start=shapes[0]) as drag:
        del deformer
        for step, shape in zip(steps[1:], shapes[1:], strict=True):
            assert np.array_equal(drag.start_solve(step).result().vertices, shape)
    with pytest.raises(meanvalue.InvalidInput, match="drag has ended"):
        drag.solve(targets)


def test_a_task_never_wants_the_interpreter():
    """It ends while this thread keeps the interpreter all the time."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e6)
    try:
        bound = meanvalue.start_bind(VERTICES, TRIANGLES, ENDS)
        _wait_without_letting_go(bound)
        task = bound.result().start_solve(bent_targets())
        _wait_without_letting_go(task)
    finally:
        sys.setswitchinterval(interval)
    assert task.result().converged


def _wait_without_letting_go(task):
    until = time.monotonic() + 60.0
    while not task.finished:
        assert time.monotonic() < until


@pytest.mark.parametrize("seconds", [0.0, 1e9, float("inf")])
def test_waiting_for_a_task(seconds):
    task = meanvalue.start_bind(VERTICES, TRIANGLES, ENDS)
    assert task.wait(seconds) is (seconds > 0.0 or task.finished)


def test_errors_of_a_task_are_those_of_the_call():
    arrays = VERTICES, TRIANGLES, ENDS
    with pytest.raises(meanvalue.InvalidInput):
        meanvalue.start_bind(VERTICES[:, :2], *arrays[1:])
    task = meanvalue.start_bind(*arrays, rigidity=-1.0)
    task.wait()
    for _ in range(2):
        with pytest.raises(meanvalue.InvalidInput, match="rigidity"):
            task.result()
    deformer, execution = meanvalue.Deformer(*arrays), meanvalue.Execution()
    with pytest.raises(meanvalue.InvalidInput):
        deformer.start_solve(bent_targets()[:-1]).result()
    execution.cancel()
    for call in (
        lambda: meanvalue.start_bind(*arrays, execution=execution).result(),
        lambda: deformer.start_solve(bent_targets(), execution=execution).result(),
        lambda: deformer.rebind(ENDS[:5], execution=execution),
        lambda: deformer.start_rebind(ENDS[:5], execution=execution).result(),
    ):
        with pytest.raises(meanvalue.Cancelled):
            call()
    assert deformer.solve(bent_targets()).converged


def test_a_process_ends_under_a_task():
    code = (
        "import sys\n"
        f"sys.path[:0] = {sys.path!r}\n"
        "import meanvalue\n"
        "from blender_tests.support.native_calls import tube\n"
        "task = meanvalue.start_bind(*tube(300, 300), [*range(300), *range(89700, 90000)])\n"
        "assert not task.finished\n"
    )
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert (ended.returncode, ended.stderr) == (0, "")


# -- bound again; its bits and threads are tested in C++ ---------------------------------------------------------------


def test_options_are_those_of_a_bind_and_the_earlier_deformer_stays():
    roi, anchors, targets = VERTICES[:, 2] > 3.0, ENDS[12:], bent_targets()[12:]
    options = {"handles": np.arange(12) // 6, "rigidity": 40.0, "strengths": np.repeat([np.inf, 0.5], 6)}
    options["stiffness"] = 1.0 + np.arange(len(VERTICES)) % 3
    earlier = meanvalue.Deformer(VERTICES, TRIANGLES, anchors[:3], roi=roi, portable=True)
    before = earlier.solve(targets[:3]).vertices
    fresh = meanvalue.Deformer(VERTICES, TRIANGLES, anchors, roi=roi, portable=True, **options).solve(targets)
    for deformer in (earlier.rebind(anchors, **options), earlier.start_rebind(anchors, **options).result()):
        assert np.array_equal(deformer.solve(targets).vertices, fresh.vertices)
        assert deformer.report.anchor_count == 12
    assert np.array_equal(earlier.solve(targets[:3]).vertices, before)


def test_what_is_worn_follows():
    worn = VERTICES * [1.05, 1.05, 0.9]
    follower = meanvalue.Follower(VERTICES, TRIANGLES, worn, TRIANGLES)
    assert follower.kinds == ("cloth",) and follower.parts.dtype == np.int32 and not follower.parts.any()
    posed = meanvalue.Deformer(VERTICES, TRIANGLES, ENDS).solve(bent_targets()).vertices
    assert np.abs(follower.follow(VERTICES) - worn).max() < 1e-10
    assert np.array_equal(follower.start_follow(posed, threads=1).result(), follower.follow(posed))
    assert meanvalue.Follower(VERTICES, TRIANGLES, worn, TRIANGLES, kind="rigid").kinds == ("rigid",)
    with pytest.raises(meanvalue.InvalidInput, match="kind is 'silk'; give 'auto', 'cloth' or 'rigid'"):
        meanvalue.Follower(VERTICES, TRIANGLES, worn, TRIANGLES, kind="silk")


def test_shape_keys_are_carried_to_another_mesh():
    quads = np.array([[0, 1, 4, 3], [1, 2, 5, 4]])
    rest = np.array([[x, y, 0.0] for y in (0, 1) for x in (0, 1, 2)], np.float32)
    shapes = np.stack([rest, rest + np.float32([0.0, 0.0, 0.5])])
    where = np.array([0, 0, 2]), np.eye(3)
    given = rest, shapes, quads, 2.0 * rest[[0, 1, 5]], [[0, 1, 2]], where
    found = meanvalue.transfer(*given)
    assert np.array_equal(found[0], 2.0 * rest[[0, 1, 5]]) and np.allclose(found[1], found[0] + [0.0, 0.0, 1.0])
    assert np.array_equal(meanvalue.start_transfer(*given, close=np.zeros(2, bool), threads=1).result(), found)
    with pytest.raises(meanvalue.InvalidInput, match="face 4 and weights 1 0 0 for vertex 0; give one of the 4"):
        meanvalue.transfer(*given[:5], (np.array([4, 0, 2]), np.eye(3)))
    with pytest.raises(meanvalue.InvalidInput, match="correspondence is no pair"):
        meanvalue.transfer(*given[:5], np.eye(3))


def test_bones_play_a_clip():
    posed = meanvalue.Deformer(VERTICES, TRIANGLES, ENDS).solve(bent_targets()).vertices
    frames = np.array([VERTICES, posed, VERTICES + 1.0], np.float32)
    found = meanvalue.fit_bones(VERTICES, frames, count=6, faces=TRIANGLES)
    assert found.weights.shape == (len(VERTICES), 6) and found.transforms.shape == (3, 6, 4, 4)
    points = np.c_[VERTICES, np.ones(len(VERTICES))]
    placed = np.einsum("nb,fbij,nj->fni", found.weights, found.transforms[..., :3, :], points)
    assert np.allclose(np.linalg.norm(placed - frames, axis=2), found.errors, atol=1e-5)
    armature = (found.heads, found.tails, found.parents, found.transforms)
    again = meanvalue.start_fit_bones(VERTICES, list(frames), armature=armature, faces=TRIANGLES).result()
    assert again.errors.max() < 2 * found.errors.max() and (again.parents == found.parents).all()
    with pytest.raises(meanvalue.InvalidInput, match=r"frames\[1\] has 1 positions"):
        meanvalue.fit_bones(VERTICES, [frames[0], frames[0, :1]])
