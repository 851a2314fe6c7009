# SPDX-License-Identifier: GPL-3.0-or-later
"""Examples in the solver, as Python has them; the solver itself is tested by native/tests/examples_test.cpp."""

import numpy as np
import pytest

meanvalue = pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")

from blender_tests.support import bent_tubes  # noqa: E402
from native.benchmarks import generated_meshes  # noqa: E402

ANCHORS = 8


@pytest.fixture(scope="module")
def bar():
    """(vertices, faces, anchors) of a bar along z."""
    vertices, faces = generated_meshes.bar(1500, bumpy=False)
    return vertices, faces, np.linspace(0, len(vertices) - 1, ANCHORS).astype(int)


def bent(vertices, angle):
    return bent_tubes.elbow(vertices, angle, 0.5)


def test_weights_are_told_and_sum_to_one(bar):
    vertices, faces, anchors = bar
    deformer = meanvalue.Deformer(vertices, faces, anchors, examples=[bent(vertices, 1.4), bent(vertices, -1.0)])
    solution = deformer.solve(bent(vertices, 0.8)[anchors])
    assert solution.example_weights.shape == (len(vertices), 3)
    np.testing.assert_allclose(solution.example_weights.sum(axis=1), 1, atol=1e-9)
    assert solution.example_weights[:, 1].max() > 0.3
    assert meanvalue.Deformer(vertices, faces, anchors).solve(vertices[anchors]).example_weights is None


@pytest.mark.parametrize(
    ("examples", "words"),
    [
        (3, "examples is no sequence"),
        ([np.zeros((4, 2))], r"examples\[0\]"),
    ],
)
def test_what_is_no_example_is_named(bar, examples, words):
    vertices, faces, anchors = bar
    with pytest.raises(meanvalue.InvalidInput, match=words):
        meanvalue.Deformer(vertices, faces, anchors, examples=examples)
