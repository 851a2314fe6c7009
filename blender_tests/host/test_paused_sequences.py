# SPDX-License-Identifier: GPL-3.0-or-later
"""Clips that stop between two frames and are gone on with later: the bits are those without the pause."""

import threading
import time

import numpy as np
import pytest

meanvalue = pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")

from blender_tests.host.test_sequences import bar, swing  # noqa: E402

FRAMES = 60
RUNS = {"chunk": 16, "overlap": 4}


def hard():
    points, faces, anchors, pieces = bar(2600)
    return meanvalue.Deformer(points, faces, anchors, handles=pieces), swing(points, anchors, pieces, FRAMES), None


def soft():
    """Twelve soft single vertices that come and go: what counts changes from frame to frame."""
    points, faces, anchors, pieces = bar(2600)
    posed = meanvalue.Deformer(points, faces, anchors, handles=pieces).solve_sequence(
        swing(points, anchors, pieces, FRAMES)
    )
    chosen = np.linspace(0, len(points) - 1, 12).astype(np.int32)
    weights = np.ones((FRAMES, 12))
    weights[5:25, 4], weights[18:40, 6], weights[30:, 9] = 0.0, 0.5, 0.0
    targets = np.where(weights[..., None] > 0.0, posed.vertices[:, chosen], np.nan)
    return meanvalue.Deformer(points, faces, chosen, strengths=np.full(12, 2.0)), targets, weights


def failing():
    """Frames in the middle that cannot be solved, across two runs."""
    deformer, targets, _ = hard()
    targets = targets.copy()
    targets[28:34] = np.nan
    return deformer, targets, None


def with_loose_part():
    """A part that nothing holds follows."""
    points, faces, anchors, pieces = bar(600)
    beside = points[:40] * 0.1 + points.mean(axis=0) + [0.0, 0.4 * np.ptp(points, axis=0)[1], 0.0]
    more = faces[(faces < 40).all(axis=1)]
    loose = np.concatenate([points, beside])
    both = np.concatenate([faces, more + len(points)]).astype(np.int32)
    deformer = meanvalue.Deformer(loose, both, anchors, handles=pieces, loose="follow")
    return deformer, swing(points, anchors, pieces, FRAMES), None


CLIPS = {"hard": hard, "soft": soft, "failing": failing, "with a loose part": with_loose_part}


@pytest.fixture(scope="module", params=CLIPS)
def clip(request):
    """(deformer, targets, options, the whole at once)."""
    deformer, targets, weights = CLIPS[request.param]()
    options = {"weights": weights, **RUNS}
    return deformer, targets, options, deformer.solve_sequence(targets, threads=1, **options)


def paused_at(share, deformer, targets, **options):
    """What comes of a clip that is paused once so much of it is solved."""
    execution = meanvalue.Execution()
    task = deformer.start_solve_sequence(targets, execution=execution, **options)
    while not task.finished and (execution.stage != "solve" or execution.progress < share):
        time.sleep(0.0002)
    execution.pause()
    return task.result()


def assert_same(found, wanted):
    assert not found.is_paused
    assert len(found.state) == len(found.solved) == 0
    np.testing.assert_array_equal(found.vertices, wanted.vertices)
    np.testing.assert_array_equal(found.energies, wanted.energies)
    np.testing.assert_array_equal(found.iterations, wanted.iterations)
    np.testing.assert_array_equal(found.converged, wanted.converged)
    assert found.errors == wanted.errors


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("share", [0.0, 0.1, 0.4, 0.6, 0.9])
def test_gone_on_with_it_has_the_bits_of_the_whole(clip, share, threads):
    deformer, targets, options, whole = clip
    paused = paused_at(share, deformer, targets, threads=threads, **options)
    if paused.is_paused:  # else it was quicker
        assert len(paused.vertices) == 0
        assert paused.solved.shape == (FRAMES,)
        assert not paused.solved.all() or share > 0.5  # frames before a run's own may be left
        state = paused.state.copy()
        del paused
        assert_same(deformer.solve_sequence(targets, resume=state, threads=3 - threads, **options), whole)
    else:
        assert_same(paused, whole)


def test_paused_as_often_as_it_may_be(clip):
    deformer, targets, options, whole = clip
    state, pauses, solved = None, 0, 0
    while True:
        execution = meanvalue.Execution()
        beside = threading.Timer(0.01, execution.pause)
        beside.start()
        result = deformer.solve_sequence(targets, resume=state, threads=2, execution=execution, **options)
        beside.cancel()
        if not result.is_paused:
            break
        assert result.solved.sum() >= solved, "nothing is lost"
        state, pauses, solved = result.state.copy(), pauses + 1, result.solved.sum()
        assert pauses < 1000
    assert_same(result, whole)


def test_a_part_of_a_clip(clip):
    deformer, targets, options, whole = clip
    paused = paused_at(0.5, deformer, targets, frames=(10, 45), threads=2, **options)
    state = paused.state.copy() if paused.is_paused else None
    part = deformer.solve_sequence(targets, frames=(10, 45), resume=state, **options)
    np.testing.assert_array_equal(part.vertices, whole.vertices[10:45])


def test_progress_goes_on_where_it_was(clip):
    deformer, targets, options, _ = clip
    paused = paused_at(0.5, deformer, targets, threads=1, **options)
    assert paused.is_paused
    execution = meanvalue.Execution()
    task = deformer.start_solve_sequence(targets, resume=paused.state, execution=execution, **options)
    first = 0.0
    while first == 0.0 and not task.finished:
        first = execution.progress
    assert first >= 0.45
    task.result()


def test_before_anything_is_solved_nothing_is_kept(clip):
    deformer, targets, options, whole = clip
    execution = meanvalue.Execution()
    execution.pause()
    paused = deformer.solve_sequence(targets, execution=execution, **options)
    assert paused.is_paused and execution.pausing and not execution.cancelled
    assert not paused.solved.any()
    assert_same(deformer.solve_sequence(targets, resume=paused.state, **options), whole)


@pytest.mark.parametrize("method", ["paper", "full"])
def test_other_methods(method):
    points, faces, anchors, _ = bar(200)
    deformer = meanvalue.Deformer(points, faces, anchors, method=method)
    targets = swing(points, anchors, bar(200)[3], 12)
    whole = deformer.solve_sequence(targets, chunk=6, overlap=2)
    paused = paused_at(0.3, deformer, targets, chunk=6, overlap=2, threads=1)
    state = paused.state.copy() if paused.is_paused else None
    assert_same(deformer.solve_sequence(targets, chunk=6, overlap=2, resume=state), whole)


def test_another_binding_of_the_same_goes_on():
    deformer, targets, _ = hard()
    whole = deformer.solve_sequence(targets, **RUNS)
    paused = paused_at(0.5, deformer, targets, threads=2, **RUNS)
    assert paused.is_paused
    assert_same(hard()[0].solve_sequence(targets, resume=paused.state, **RUNS), whole)


def bound_otherwise(turned_faces=False, **options):
    """As hard() is, but for one thing."""
    points, faces, anchors, pieces = bar(2600)
    if turned_faces:
        faces = np.roll(faces, 1, axis=1)
    return meanvalue.Deformer(points, faces, anchors, **{"handles": pieces, **options})


OTHER_BINDINGS = {
    "rigidity": lambda: bound_otherwise(rigidity=0.5),
    "handles": lambda: bound_otherwise(handles=None),
    "strengths": lambda: bound_otherwise(strengths=np.full(len(bar(2600)[2]), 2.0)),
    "faces": lambda: bound_otherwise(turned_faces=True),
    "portable": lambda: bound_otherwise(portable=True),
    "method": lambda: bound_otherwise(method="paper", handles=None),
}


def test_a_state_of_something_else_or_a_damaged_one_is_refused():
    deformer, targets, _ = hard()
    paused = paused_at(0.3, deformer, targets, threads=1, **RUNS)
    assert paused.is_paused
    state = paused.state.copy()
    for other in (
        lambda: deformer.solve_sequence(targets * 1.001, resume=state, **RUNS),
        lambda: deformer.solve_sequence(targets, resume=state, frames=(0, 50), **RUNS),
        lambda: deformer.solve_sequence(targets, resume=state, tolerance=1e-6, **RUNS),
        lambda: deformer.solve_sequence(targets, resume=state, chunk=20, overlap=4),
    ):
        with pytest.raises(meanvalue.InvalidInput, match="another clip"):
            other()
    for other_binding in OTHER_BINDINGS.values():
        with pytest.raises(meanvalue.InvalidInput, match="another clip"):
            other_binding().solve_sequence(targets, resume=state, **RUNS)
    chance = np.random.default_rng(1)
    for _ in range(50):
        damaged = state.copy()
        damaged[chance.integers(len(damaged))] ^= 1 << chance.integers(8)
        with pytest.raises(meanvalue.InvalidInput, match="damaged"):
            deformer.solve_sequence(targets, resume=damaged, **RUNS)
    for length in (0, 1, 7, 8, 100, len(state) - 1):
        if length:
            with pytest.raises(meanvalue.InvalidInput, match="damaged"):
                deformer.solve_sequence(targets, resume=state[:length], **RUNS)
    with pytest.raises(meanvalue.InvalidInput, match="on_frame"):
        deformer.solve_sequence(targets, resume=state, on_frame=lambda *_: None, **RUNS)


def test_frames_that_are_handed_over_are_not_paused():
    deformer, targets, _ = hard()
    execution = meanvalue.Execution()
    execution.pause()
    frames = []
    deformer.solve_sequence(targets, on_frame=lambda frame, _: frames.append(frame), execution=execution, **RUNS)
    assert frames == list(range(FRAMES))
