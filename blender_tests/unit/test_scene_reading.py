# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading an object bit by bit gives what reading it in one go gives."""

import numpy as np
from support import meshes, steps


def test_in_slices_as_in_one_go(part, monkeypatch):
    monkeypatch.setattr(part("scene.vertex_groups"), "SLICE", 4)
    obj = meshes.grid()
    steps.list_anchors(obj, A=[0, 4, 20], B=[24, 23])
    steps.add_group(obj, "Region", range(10, 25))
    obj.meanvalue.roi_group = "Region"
    reading = part("posing.bridge.scene_input").HandleReading
    whole, sliced = reading(obj), reading(obj)
    assert whole.go_on(obj)
    shares = []
    while not sliced.go_on(obj, 0.0):
        shares.append(sliced.share)
    assert len(shares) >= 6 and shares == sorted(shares)
    assert {name: list(found) for name, found in sliced.members.items()} == {
        "A": [0, 4, 20],
        "B": [23, 24],
        "Region": list(range(10, 25)),
    }
    assert all(np.array_equal(whole.members[name], sliced.members[name]) for name in whole.members)
    assert all(np.array_equal(*pair) for pair in zip(whole.faces, sliced.faces, strict=True))
