# SPDX-License-Identifier: GPL-3.0-or-later
"""Every operator is one undo step. Operators called with undo=True push a step as they do from a button."""

import bpy
import pytest
from support import meshes, steps
from support.snapshot import assert_same, snapshot


@pytest.fixture(autouse=True)
def undo_works_here():
    if not bpy.ops.ed.undo_push.poll():
        pytest.skip("this Blender has no undo without a window")


def remember():
    bpy.ops.ed.undo_push(message="Before")
    return snapshot(current())


def current():
    """References do not survive undo: look the object up again."""
    return bpy.data.objects["Grid"]


def press(operator):
    assert operator('EXEC_DEFAULT', True) == {'FINISHED'}


def posed():
    return steps.posed_grid(meshes.grid())


def solved():
    posed()
    steps.solve()


def edited():
    posed().vertex_groups["Tip"].add([22], 1.0, 'REPLACE')


def listed(*members):
    obj = meshes.grid()
    steps.list_anchors(obj, A=members)
    return obj


def with_a_region():
    obj = listed(12)
    steps.add_group(obj, "Region", [3, 4])
    obj.meanvalue.roi_group = "Region"


def painting():
    listed(12)
    bpy.ops.meanvalue.paint_region()


CASES = {
    "solve": (posed, "solve_from_key"),
    "solve that binds again": (edited, "solve_from_key"),
    "bind": (lambda: listed(0, 4, 20), "bind"),
    "apply": (solved, "apply_pose"),
    "remove": (lambda: listed(0), "remove_handle"),
    "grow what is there": (with_a_region, "grow_region"),
    "paint": (lambda: listed(12), "paint_region"),
    "end of painting": (painting, "paint_region"),
}


@pytest.mark.parametrize("set_up, operator", CASES.values(), ids=CASES.keys())
def test_undo_and_redo(set_up, operator):
    set_up()
    before = remember()
    press(getattr(bpy.ops.meanvalue, operator))
    after = snapshot(current())
    assert after != before
    bpy.ops.ed.undo()
    assert_same(before, snapshot(current()))
    bpy.ops.ed.redo()
    assert_same(after, snapshot(current()))
    bpy.ops.ed.undo()
    assert_same(before, snapshot(current()))


def test_keyframes_that_are_inserted_in_edit_mode():
    obj = meshes.grid()
    steps.add_group(obj, "A", [12])
    bpy.ops.meanvalue.add_handle()
    meshes.activate(current())
    bpy.ops.object.mode_set(mode='EDIT')
    remember()
    press(bpy.ops.meanvalue.keyframe_handles)
    assert len(bpy.data.actions) == 1
    bpy.ops.ed.undo()
    assert current().meanvalue.handles[0].control.animation_data is None


def test_toggle_live():
    """The shape is compared elsewhere: while Live is on the mesh is posed, which no step of the operator holds."""
    steps.list_anchors(meshes.grid(), A=[0, 4, 20])
    steps.add_group(current(), "Tip", [24])
    bpy.ops.meanvalue.add_handle(group="Tip", live=False)  # its control is the active object
    remember()
    for turned_on in (True, False):
        bpy.ops.wm.context_toggle('EXEC_DEFAULT', True, data_path="scene.meanvalue_live")
        assert current().meanvalue.live == turned_on
        bpy.ops.ed.undo()
        assert current().meanvalue.live != turned_on
        bpy.ops.ed.redo()
        assert current().meanvalue.live == turned_on


def test_solve_after_undo_and_redo_is_the_same():
    steps.posed_grid(meshes.grid())
    remember()
    press(bpy.ops.meanvalue.solve_from_key)
    first = steps.key_positions(current(), "Mean-Value").tobytes()
    bpy.ops.ed.undo()
    press(bpy.ops.meanvalue.solve_from_key)
    assert steps.key_positions(current(), "Mean-Value").tobytes() == first
