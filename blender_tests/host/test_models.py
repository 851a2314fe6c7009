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


@pytest.mark.slow
@pytest.mark.parametrize("path", paths("messy"))
def test_messy_meshes_too_and_every_fallback_is_reported(path):
    vertices, triangles = mesh_files.read_triangles(path)
    encoding = meanvalue.encode(vertices, triangles)
    assert largest_error(encoding, vertices) < 1e-12
    named = np.unique(np.concatenate([[], *encoding.guarded_by.values()]))
    assert np.array_equal(named, encoding.guarded)
