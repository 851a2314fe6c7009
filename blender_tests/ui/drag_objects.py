# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own transforms, by mouse and keys: they show that the driver does what an artist's hand does."""

import math

import bpy
from support import meshes


def cube():
    """The only object of the scene. References do not survive undo: it is looked up again."""
    return bpy.data.objects["Cube"]


def _make_cube(ui):
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    meshes.make_object(corners, faces, "Cube")
    ui.remember()


def drag_undo_redo(ui):
    _make_cube(ui)
    seen = [ui.project(cube().location)]

    def look(step):
        seen.append(ui.project(cube().location))
        if step == 2:
            yield from ui.screenshot("in_mid_drag", amid_work=True)
            assert ui.reports() == []

    yield from ui.drag_by_keys('G', 150, 80, between=look)
    across = [x for x, _y in seen]
    assert across == sorted(across) and len(set(across)) == 6, seen
    assert abs(seen[-1][0] - seen[0][0] - 150) <= 2 and abs(seen[-1][1] - seen[0][1] - 80) <= 2, seen
    dropped = cube().location.copy()
    assert (dropped - cube().matrix_world.translation).length < 1e-6
    yield from ui.screenshot("dragged")
    yield from ui.undo()
    assert cube().location.length == 0.0
    yield from ui.redo()
    assert (cube().location - dropped).length < 1e-6
    assert any("bpy.ops.transform.translate" in line for line in ui.reports()), ui.reports()


def rotate_by_typed_numbers(ui):
    _make_cube(ui)
    yield from ui.move_mouse(*ui.project((3.0, 0.0, 0.0)))
    yield from ui.key('R')
    yield from ui.type("z-30.5")
    yield from ui.key('RET')
    assert abs(math.degrees(cube().rotation_euler.z) + 30.5) < 1e-3, cube().rotation_euler
    yield from ui.undo()
    assert cube().rotation_euler.z == 0.0


def escape_during_a_drag(ui):
    _make_cube(ui)
    moved = []
    yield from ui.drag_by_keys('G', 120, 0, between=lambda step: moved.append(cube().location.length), end='ESC')
    assert moved[-1] > 0.1
    assert cube().location.length == 0.0
    assert ui.reports() == []


def _make_second_cube():
    second = cube().copy()
    second.location.x = 4.0
    bpy.context.collection.objects.link(second)
    return second.name


def select_by_click(ui):
    _make_cube(ui)
    second = _make_second_cube()
    ui.frame_all()
    yield
    yield from ui.click(*ui.project((4.0, 0.0, 0.0)))
    assert [obj.name for obj in bpy.context.selected_objects] == [second]
    yield from ui.click(*ui.project((0.0, 0.0, 0.0)), shift=True)
    assert len(bpy.context.selected_objects) == 2
    yield from ui.key('TAB')
    assert cube().mode == 'EDIT'
    yield from ui.screenshot("edit_mode_of_two")


def select_by_box(ui):
    _make_cube(ui)
    second = _make_second_cube()
    ui.frame_all()
    yield
    x, y = ui.project((4.0, 0.0, 0.0))
    yield from ui.drag_mouse((x + 300, y - 150), (x, y))
    assert [obj.name for obj in bpy.context.selected_objects] == [second]
