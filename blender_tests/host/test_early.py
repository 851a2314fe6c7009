# SPDX-License-Identifier: GPL-3.0-or-later
"""What the Python module has to offer of a mesh while it is being bound."""

import meanvalue
import numpy as np
import pytest

from native.benchmarks import generated_creature


@pytest.fixture(scope="module")
def creature():
    """(vertices, faces, anchors, targets): six patches of a creature, one of them carried."""
    vertices, faces = generated_creature.creature(30_000)
    size = np.linalg.norm(np.ptp(vertices, axis=0))
    seeds = [vertices[:, axis].argmin() for axis in range(3)] + [vertices[:, axis].argmax() for axis in range(3)]
    distances = np.linalg.norm(vertices[:, None] - vertices[seeds], axis=2)
    anchors = np.flatnonzero(distances.min(axis=1) < 0.02 * size)
    targets = vertices[anchors].copy()
    targets[distances[anchors].argmin(axis=1) == 5] += 0.05 * size
    return vertices, faces, anchors, targets


def early_of(task):
    """The first that there is, or None where all is bound before it was seen."""
    while task.early is None and not task.wait(0.001):
        pass
    return task.early


def test_it_is_gone_once_the_whole_is_there(creature):
    vertices, faces, anchors, _targets = creature
    task = meanvalue.start_bind(vertices, faces, anchors, early=True)
    early = early_of(task)
    assert early is not None and early.report.anchor_count == len(anchors)
    assert task.result() is not None and task.early is None


def test_it_outlives_a_bind_that_is_cancelled(creature):
    vertices, faces, anchors, targets = creature
    execution = meanvalue.Execution()
    task = meanvalue.start_bind(vertices, faces, anchors, early=True, execution=execution)
    early = early_of(task)
    execution.cancel()
    with pytest.raises(meanvalue.Cancelled):
        task.result()
    task.wait()
    assert task.early is None
    first = early.solve(targets).vertices
    assert np.array_equal(early.solve(targets).vertices, first)
