# SPDX-License-Identifier: GPL-3.0-or-later
"""The examples of the documentation that need no Blender run as they stand."""

import pathlib
import re

import numpy as np

INSTALLING = pathlib.Path(__file__).resolve().parents[2] / "docs" / "installing.md"


def test_the_first_example_poses_a_strip():
    (code,) = re.findall(r"(?ms)^```python\n(.*?)^```", INSTALLING.read_text())
    names = {}
    exec(code, names)
    vertices, posed, anchors = names["vertices"], names["posed"], names["anchors"]
    assert np.array_equal(posed[anchors], names["targets"])
    free = np.setdiff1d(np.arange(len(vertices)), anchors)
    assert (posed[free, 2] > 0.0).any(), "nothing follows"

    def lengths(positions):
        """Of the edges along the strip, which the default method keeps."""
        return np.linalg.norm(positions[2:] - positions[:-2], axis=1)

    assert np.abs(lengths(posed) / lengths(vertices) - 1.0).max() < 0.25
