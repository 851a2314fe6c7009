# SPDX-License-Identifier: GPL-3.0-or-later
"""Deformer.rebind() as Python sees it: options, tasks, errors. Its bits and threads are tested in C++."""

import numpy as np
import pytest

meanvalue = pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")

from blender_tests.support.native_calls import ENDS, TRIANGLES, VERTICES, bent_targets  # noqa: E402


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


def test_it_is_cancelled():
    execution = meanvalue.Execution()
    execution.cancel()
    earlier = meanvalue.Deformer(VERTICES, TRIANGLES, ENDS)
    with pytest.raises(meanvalue.Cancelled):
        earlier.rebind(ENDS[:5], execution=execution)
    with pytest.raises(meanvalue.Cancelled):
        earlier.start_rebind(ENDS[:5], execution=execution).result()


def test_what_is_wrong_is_told_as_by_a_fresh_bind():
    earlier = meanvalue.Deformer(VERTICES, TRIANGLES, [0, 5], method="paper")
    with pytest.raises(meanvalue.InvalidInput, match="vertex -1"):
        earlier.rebind([0, -1])
    with pytest.raises(meanvalue.InvalidInput, match="handles has 1 numbers"):
        earlier.rebind([0, 5], handles=[0], rigidity=None)
    with pytest.raises(meanvalue.InvalidInput, match="only method 'fast' has soft anchors"):
        earlier.rebind([0, 5], strengths=[1.0, 1.0])
