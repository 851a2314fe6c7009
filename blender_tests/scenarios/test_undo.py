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


def undo_and_redo(operator):
    before = remember()
    press(operator)
    after = snapshot(current())
    assert after != before
    bpy.ops.ed.undo()
    assert_same(before, snapshot(current()))
    bpy.ops.ed.redo()
    assert_same(after, snapshot(current()))
    bpy.ops.ed.undo()
    assert_same(before, snapshot(current()))


def test_solve():
    steps.posed_grid(meshes.grid())
    undo_and_redo(bpy.ops.meanvalue.solve_from_key)


def test_second_solve():
    obj = steps.posed_grid(meshes.grid())
    steps.solve()
    steps.move(obj, [24], (0.0, 0.0, 1.0))
    undo_and_redo(bpy.ops.meanvalue.solve_from_key)


def test_solve_that_binds_again():
    obj = steps.posed_grid(meshes.grid())
    obj.vertex_groups["Tip"].add([22], 1.0, 'REPLACE')
    undo_and_redo(bpy.ops.meanvalue.solve_from_key)


def test_bind():
    steps.list_anchors(meshes.grid(), A=[0, 4, 20])
    undo_and_redo(bpy.ops.meanvalue.bind)


def test_unbind():
    steps.bound_grid(meshes.grid())
    undo_and_redo(bpy.ops.meanvalue.unbind)


def test_remove_handle():
    steps.list_anchors(meshes.grid(), A=[0])
    undo_and_redo(bpy.ops.meanvalue.remove_handle)


def test_grow_region():
    steps.list_anchors(meshes.grid(), A=[12])
    undo_and_redo(bpy.ops.meanvalue.grow_region)


def test_growing_a_region_that_is_there():
    obj = meshes.grid()
    steps.list_anchors(obj, A=[12])
    steps.add_group(obj, "Region", [3, 4])
    obj.meanvalue.roi_group = "Region"
    obj.meanvalue.roi_invert = True
    undo_and_redo(bpy.ops.meanvalue.grow_region)


def test_a_group_that_is_added_in_edit_mode():
    obj = meshes.grid()
    steps.add_group(obj, "A", [12])
    bpy.ops.object.mode_set(mode='EDIT')
    remember()
    press(lambda *how: bpy.ops.meanvalue.add_handle(*how, group="A"))
    assert current().mode == 'OBJECT' and [line.name for line in current().meanvalue.handles] == ["A"]
    bpy.ops.ed.undo()
    assert len(current().meanvalue.handles) == 0 and len(bpy.data.objects) == 1


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


def test_paint_region():
    steps.list_anchors(meshes.grid(), A=[12])
    undo_and_redo(bpy.ops.meanvalue.paint_region)


def test_painting_ends():
    steps.list_anchors(meshes.grid(), A=[12])
    bpy.ops.meanvalue.paint_region()
    undo_and_redo(bpy.ops.meanvalue.paint_region)


def test_toggle_live():
    """The shape is compared elsewhere: while Live is on the mesh is posed, which no step of the operator holds."""
    steps.list_anchors(meshes.grid(), A=[0, 4, 20])
    steps.add_group(current(), "Tip", [24])
    bpy.ops.meanvalue.add_handle(group="Tip", live=False)
    meshes.activate(current())
    remember()
    for turned_on in (True, False):
        bpy.ops.wm.context_toggle('EXEC_DEFAULT', True, data_path="scene.meanvalue_live")
        assert current().meanvalue.live == turned_on
        bpy.ops.ed.undo()
        assert current().meanvalue.live != turned_on
        bpy.ops.ed.redo()
        assert current().meanvalue.live == turned_on


def test_the_status_follows_undo(part):
    status = part("posing.bridge.object_status").status
    steps.list_anchors(meshes.grid(), A=[0, 4, 20])
    remember()
    press(bpy.ops.meanvalue.bind)
    assert status(current()).state.name == "BOUND"
    bpy.ops.ed.undo()
    assert status(current()).state.name == "UNBOUND"
    bpy.ops.ed.redo()
    assert status(current()).state.name == "BOUND"


def test_solve_after_undo_and_redo_is_the_same():
    steps.posed_grid(meshes.grid())
    remember()
    press(bpy.ops.meanvalue.solve_from_key)
    first = steps.key_positions(current(), "Mean-Value").tobytes()
    bpy.ops.ed.undo()
    press(bpy.ops.meanvalue.solve_from_key)
    assert steps.key_positions(current(), "Mean-Value").tobytes() == first
