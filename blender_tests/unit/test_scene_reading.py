# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading an object bit by bit gives what reading it in one go gives."""

import numpy as np
from support import meshes, steps
from support.interface import interface


def test_in_slices_as_in_one_go(part, monkeypatch):
    monkeypatch.setattr(part("scene.vertex_groups"), "SLICE", 4)
    obj = meshes.grid()
    steps.list_anchors(obj, A=[0, 4, 20], B=[24, 23])
    steps.add_group(obj, "Region", range(10, 25))
    obj.meanvalue.roi_group = "Region"
    reading = part("posing.bridge.scene_input").HandleReading
    whole, sliced = reading(obj), reading(obj)
    assert whole.go_on(obj)
    slices = 1
    while not sliced.go_on(obj, 0.0):
        slices += 1
    assert slices > 6
    assert {name: list(found) for name, found in sliced.members.items()} == {
        "A": [0, 4, 20],
        "B": [23, 24],
        "Region": list(range(10, 25)),
    }
    assert all(np.array_equal(whole.members[name], sliced.members[name]) for name in whole.members)
    assert all(np.array_equal(*pair) for pair in zip(whole.faces, sliced.faces, strict=True))


def test_what_is_asked_for_is_read_at_once_though_a_timer_waits_for_quiet(part, monkeypatch):
    readings = part("scene.shared_readings")
    monkeypatch.setattr(part("scene.vertex_groups"), "SLICE", 4)
    monkeypatch.setattr(readings, "SLICE_SECONDS", 0.0)
    obj = meshes.grid()
    steps.list_anchors(obj, A=[0, 4, 20])
    with interface() as timers:
        readings.look_again_when_quiet()
        assert list(timers.first_intervals.values()) == [part("scene.object_model").QUIET_SECONDS]
        kind = part("posing.bridge.scene_input").HandleReading
        assert readings.finished(obj, kind) is None
        assert list(timers.first_intervals.values()) == [readings.PAUSE_SECONDS]
        readings.look_again_when_quiet()
        assert list(timers.first_intervals.values()) == [readings.PAUSE_SECONDS], "it is being read"
        timers.run(0.1)
        assert readings.finished(obj, kind).members["A"].tolist() == [0, 4, 20]
