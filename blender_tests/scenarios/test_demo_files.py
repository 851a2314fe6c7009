# SPDX-License-Identifier: GPL-3.0-or-later
"""The .blend files of `./dev demo` are there to be tried: they open with handles, Live on and the pose shown."""

import sys
from pathlib import Path

import bpy
import numpy as np
from support import steps

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from blender_tests.demo import built_in, pose, ready


def test_the_figure_eight_follows_its_control_when_it_is_opened(part, tmp_path):
    subject = built_in.twisted_eight()
    pose.pose_by_operators(subject)
    solved = steps.key_positions(subject.obj, subject.obj.meanvalue.result_key)
    rest = pose.positions(subject.obj)
    size = np.linalg.norm(np.ptp(rest, axis=0))
    ready.to_be_tried(subject)
    path = tmp_path / "eight.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.open_mainfile(filepath=str(path))

    obj = bpy.data.objects["Figure Eight"]
    settings = obj.meanvalue
    assert {handle.name: handle.follows for handle in settings.handles} == {"lower end": 'REST', "upper end": 'CONTROL'}
    control = settings.handles["upper end"].control
    assert bpy.context.object == control and control.select_get() and settings.live
    assert [key.name for key in obj.data.shape_keys.key_blocks] == ["Basis", settings.result_key]
    bpy.context.view_layer.update()
    # A quarter turn of the end: the control is turned with it, and what is shown is the demo's pose.
    shown = steps.key_positions(obj, settings.result_key)
    assert np.abs(shown - solved).max() < 0.02 * size
    assert abs(control.matrix_world.to_euler().z) > 1.5

    control.location.z += 0.1 * size
    bpy.context.view_layer.update()
    moved = steps.key_positions(obj, settings.result_key)
    upper, lower = (pose.group_indices(obj, name) for name in ("upper end", "lower end"))
    assert np.allclose(moved[upper] - shown[upper], (0.0, 0.0, 0.1 * size), atol=1e-3 * size)
    assert np.array_equal(moved[lower], shown[lower])
    assert part("live.engine").status(obj) is None
