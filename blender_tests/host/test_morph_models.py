# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes between real shapes. Skipped where the shared data is missing."""

import numpy as np
import pytest

meanvalue = pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")

from blender_tests.support.bent_tubes import diagonal  # noqa: E402
from native.benchmarks import bench_morph, shape_metrics  # noqa: E402

SETS = bench_morph.shape_sets()
# Pairs whose ends have no triangle turned over as seen from each other, or next to none.
PAIRS = [("man, woman", 0, 1), ("horse_poses", 0, 10), ("horse_poses", 9, 10), ("makehuman", 2, 3)]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "first", "second"), PAIRS)
def test_half_way_nothing_is_turned_over_and_the_ends_come_back(name, first, second):
    if name not in SETS:
        pytest.skip(f"no shapes {name} in {bench_morph.mesh_files.DATA}")
    shapes, faces = SETS[name]
    ends = [shapes[first], shapes[second]]
    morpher = meanvalue.Morpher(ends, faces)
    half = morpher.solve([0.5, 0.5])
    assert half.converged
    assert bench_morph.new_flips(half.vertices, ends, faces) == 0
    for weights, end in zip(np.eye(2), ends, strict=True):
        back = morpher.solve(weights).vertices
        assert np.linalg.norm(back - end, axis=1).max() < 1e-6 * diagonal(end)
    lengths = [np.linalg.norm(np.diff(shape[shape_metrics.unique_edges(faces)], axis=1), axis=2) for shape in ends]
    between = np.linalg.norm(np.diff(half.vertices[shape_metrics.unique_edges(faces)], axis=1), axis=2)
    ratios = between / np.maximum(0.5 * sum(lengths), 1e-12)
    assert abs(np.median(ratios) - 1) < 0.02
