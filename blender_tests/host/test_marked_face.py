# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/sliders/core/marked_face.py: which markers tell something of a face."""

import numpy as np

from addon.sliders.core import marked_face
from blender_tests.support import faces


def test_stuck_markers_are_found_among_those_that_move():
    path = faces.recorded(faces.values(), faces.marked(20), gaps=0.1)
    path[:, 3] = path[0, 3]
    path[:, 5] = np.nan
    assert np.flatnonzero(marked_face.still(path)).tolist() == [3, 5]


def test_markers_of_something_else_are_far():
    places = faces.rest()[0][faces.marked(20)]
    distance = np.full(20, 0.01)
    distance[7] = 0.2
    assert np.flatnonzero(marked_face.far(places, distance)).tolist() == [7]


def test_on_a_head_that_stands_still_markers_may_stand_still():
    path = np.tile(faces.rest()[0][faces.marked(20)], (10, 1, 1))
    path[:, 4, 2] += np.linspace(0.0, 0.01, 10)
    assert not marked_face.still(path).any()
    assert marked_face.still(path[:1]).all()
