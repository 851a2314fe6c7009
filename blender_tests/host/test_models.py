# SPDX-License-Identifier: GPL-3.0-or-later
"""The encoding on real meshes, clean and messy. Skipped where the shared data is missing."""

import numpy as np
import pytest

meanvalue = pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")

from blender_tests.support import mesh_files  # noqa: E402


def paths(folder):
    found = mesh_files.model_paths(folder)
    if found:
        return [pytest.param(path, id=path.name) for path in found]
    return [pytest.param(None, marks=pytest.mark.skip(reason=f"no meshes in {mesh_files.DATA / folder}"))]


def largest_error(encoding, vertices):
    """Of predict() at rest, as a share of the bounding-box diagonal."""
    diagonal = np.linalg.norm(np.ptp(vertices, axis=0))
    return np.linalg.norm(encoding.predict(vertices) - vertices, axis=1).max() / diagonal


@pytest.mark.parametrize("path", paths("messy"))
def test_messy_meshes_too_and_every_fallback_is_reported(path):
    vertices, triangles = mesh_files.read_triangles(path)
    encoding = meanvalue.encode(vertices, triangles)
    assert largest_error(encoding, vertices) < 1e-12
    named = np.unique(np.concatenate([[], *encoding.guarded_by.values()]))
    assert np.array_equal(named, encoding.guarded)


def spread_anchors(count, triangles, step):
    """Every `step`-th vertex, and all of each part that has too few of those to be determined."""
    part = np.arange(count)
    for _ in range(count):
        lowest = part[triangles].min(axis=1)
        before = part.copy()
        np.minimum.at(part, triangles, lowest[:, None])
        part = part[part]
        if np.array_equal(part, before):
            break
    chosen = np.arange(count) % step == 0
    sizes = np.bincount(part[chosen], minlength=count)
    return np.flatnonzero(chosen | (sizes[part] < 4))


@pytest.mark.parametrize(("name", "step"), [("feline.off", 5000), ("octopus.off", 40)])
def test_the_hierarchy_gives_the_shape_back_under_a_similarity(name, step):
    """feline: genus 2, whose base mesh keeps unknowns where anchors are few; octopus: several parts."""
    vertices, triangles = mesh_files.read_triangles(mesh_files.path_of(f"models/{name}"))
    anchors = spread_anchors(len(vertices), triangles, step)
    deformer = meanvalue.Deformer(vertices, triangles, anchors, method="paper")
    if name == "feline.off":
        assert deformer.report.level_sizes[-1] > 0
    assert all(part.undetermined == 0 for part in deformer.report.components if part.free_count)
    diagonal = np.linalg.norm(np.ptp(vertices, axis=0))
    still = deformer.solve(vertices[anchors]).vertices
    assert np.abs(still - vertices).max() < 1e-9 * diagonal
    quarter_turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    moved = 1.7 * vertices @ quarter_turn.T + [3.0, -1.0, 2.0]
    carried = deformer.solve(moved[anchors]).vertices
    assert np.abs(carried - moved).max() < 1e-9 * 1.7 * diagonal
