# SPDX-License-Identifier: GPL-3.0-or-later
"""Deformer.rebind(): the bits of a fresh bind, from Python and as a task; the earlier deformer stays as it was."""

import gc
import threading

import numpy as np
import pytest

meanvalue = pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")

from blender_tests.support import stress  # noqa: E402

METHODS = ("fast", "paper", "full")


def tube(method):
    return stress.bar(3000 if method == "fast" else 400)


def handles(vertices, count, seed):
    """Vertex numbers and their pieces: the vertices nearest to `count` random ones, eight each."""
    centres = vertices[np.random.default_rng(seed).choice(len(vertices), count, replace=False)]
    nearest = np.argsort(np.linalg.norm(vertices - centres[:, None], axis=2), axis=1, kind="stable")[:, :8]
    anchors, first = np.unique(nearest, return_index=True)
    return anchors.astype(np.int32), (first // 8).astype(np.int32)


def moved(vertices, anchors, pieces):
    return vertices[anchors] + 0.05 * np.stack([np.sin(pieces), np.cos(pieces), 0.0 * pieces], axis=1)


@pytest.mark.parametrize("method", METHODS)
def test_bits_are_those_of_a_fresh_bind_whatever_was_bound_before(method):
    vertices, faces = tube(method)[:2]
    deformer = meanvalue.Deformer(vertices, faces, *handles(vertices, 2, 0)[:1], method=method)
    for seed in range(1, 4):
        anchors, pieces = handles(vertices, 1 + seed, seed)
        deformer = deformer.rebind(anchors, handles=pieces)  # the earlier one is let go
        gc.collect()
        fresh = meanvalue.Deformer(vertices, faces, anchors, handles=pieces, method=method)
        targets = moved(vertices, anchors, pieces)
        assert np.array_equal(deformer.solve(targets).vertices, fresh.solve(targets).vertices)
        assert deformer.report.level_sizes == fresh.report.level_sizes
        assert deformer.report.anchor_count == len(anchors)


def test_strengths_rigidity_and_region_are_as_in_a_fresh_bind():
    vertices, faces = tube("fast")[:2]
    roi = vertices[:, 2] > np.quantile(vertices[:, 2], 0.2)
    anchors, pieces = handles(vertices[:], 3, 4)
    anchors, pieces = anchors[roi[anchors]], pieces[roi[anchors]]
    strengths = np.where(pieces == pieces[0], np.inf, 0.5)
    options = {"handles": pieces, "rigidity": 40.0, "strengths": strengths}
    earlier = meanvalue.Deformer(vertices, faces, anchors[:1], roi=roi, portable=True)
    targets = moved(vertices, anchors, pieces)
    again = earlier.rebind(anchors, **options).solve(targets)
    fresh = meanvalue.Deformer(vertices, faces, anchors, roi=roi, portable=True, **options).solve(targets)
    assert np.array_equal(again.vertices, fresh.vertices)


def test_the_earlier_deformer_stays_usable_and_several_bind_from_it_at_once():
    vertices, faces = tube("fast")[:2]
    first = handles(vertices, 2, 5)
    earlier = meanvalue.Deformer(vertices, faces, first[0], handles=first[1])
    before = earlier.solve(moved(vertices, *first)).vertices
    others = [handles(vertices, 2 + seed, 10 + seed) for seed in range(3)]
    tasks = [earlier.start_rebind(anchors, handles=pieces) for anchors, pieces in others]
    threads = [threading.Thread(target=task.result) for task in tasks]
    for thread in threads:
        thread.start()
    assert np.array_equal(earlier.solve(moved(vertices, *first)).vertices, before)
    for thread in threads:
        thread.join()
    for task, (anchors, pieces) in zip(tasks, others, strict=True):
        fresh = meanvalue.Deformer(vertices, faces, anchors, handles=pieces)
        targets = moved(vertices, anchors, pieces)
        assert np.array_equal(task.result().solve(targets).vertices, fresh.solve(targets).vertices)


def test_cancelled_it_leaves_the_earlier_one_as_it_was():
    vertices, faces = tube("fast")[:2]
    anchors, pieces = handles(vertices, 2, 6)
    earlier = meanvalue.Deformer(vertices, faces, anchors, handles=pieces)
    before = earlier.solve(moved(vertices, anchors, pieces)).vertices
    execution = meanvalue.Execution()
    execution.cancel()
    more = handles(vertices, 4, 7)
    with pytest.raises(meanvalue.Cancelled):
        earlier.rebind(more[0], handles=more[1], execution=execution)
    task = earlier.start_rebind(more[0], handles=more[1], execution=execution)
    with pytest.raises(meanvalue.Cancelled):
        task.result()
    assert np.array_equal(earlier.solve(moved(vertices, anchors, pieces)).vertices, before)


def test_what_is_wrong_is_told_as_by_a_fresh_bind():
    vertices, faces = tube("paper")[:2]
    earlier = meanvalue.Deformer(vertices, faces, [0, 5], method="paper")
    with pytest.raises(meanvalue.InvalidInput, match="vertex -1"):
        earlier.rebind([0, -1])
    with pytest.raises(meanvalue.InvalidInput, match="handles has 1 numbers"):
        earlier.rebind([0, 5], handles=[0], rigidity=None)
    with pytest.raises(meanvalue.InvalidInput, match="only method 'fast' has soft anchors"):
        earlier.rebind([0, 5], strengths=[1.0, 1.0])
