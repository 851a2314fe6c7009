# SPDX-License-Identifier: GPL-3.0-or-later
"""Live turned on and off by its operator."""

import bpy
import pytest
from support import meshes, steps
from support.snapshot import assert_same, snapshot


def grid_with_handle():
    obj = meshes.grid()
    steps.list_anchors(obj, Corners=[0, 4, 20])
    steps.add_group(obj, "Hand", [24])
    bpy.ops.meanvalue.add_handle(group="Hand", live=False)
    return obj


def toggle():
    assert bpy.ops.meanvalue.toggle_live() == {'FINISHED'}


def test_on_and_off(capfd):
    obj = grid_with_handle()
    toggle()
    assert obj.meanvalue.live
    assert "Live is on: 'Grid' follows its handles" in capfd.readouterr().out
    assert "Mean-Value" in obj.data.shape_keys.key_blocks
    toggle()
    assert not obj.meanvalue.live
    assert "Live is off: 'Grid' stays as it is" in capfd.readouterr().out


def test_off_in_any_mode():
    obj = grid_with_handle()
    toggle()
    meshes.activate(obj)
    bpy.ops.object.mode_set(mode='EDIT')
    toggle()
    assert not obj.meanvalue.live


@pytest.mark.parametrize(
    "prepare, texts",
    [
        (lambda obj: obj.meanvalue.handles.clear(), ("Live stays off", "There are no handles yet", "Add Handle")),
        (lambda obj: obj.vertex_groups.remove(obj.vertex_groups["Hand"]), ("Live stays off", "no vertex group 'Hand'")),
        (lambda obj: setattr(obj.meanvalue, "result_key", " "), ("Live stays off", "The result has no name")),
        (
            lambda obj: setattr(obj.meanvalue.handles["Hand"], "control", None),
            ("Live stays off", "Handle 'Hand' has no control"),
        ),
        (lambda _obj: bpy.ops.object.mode_set(mode='EDIT'), ("is in Edit Mode", "Object Mode")),
    ],
)
def test_refused(prepare, texts):
    obj = grid_with_handle()
    meshes.activate(obj)
    prepare(obj)
    before = snapshot(obj)
    with steps.refused(*texts):
        bpy.ops.meanvalue.toggle_live()
    assert_same(before, snapshot(obj))
