# SPDX-License-Identifier: GPL-3.0-or-later
"""The Grab tool, by the mouse: from a fresh mesh to a drag, its size, pins, Finish."""

import cProfile
from unittest import mock

import bpy
import numpy as np
from harness import grab, view
from support import installed, meshes, rings, steps


def three_acts_from_a_fresh_mesh(ui):
    yield from grab.set_up(ui)
    rest = grab.seen()
    start = ui.project(grab.front(z=1.2))
    operator, profile = installed.part("posing.operators.grab").MEANVALUE_OT_grab, cProfile.Profile()
    run, invoke = profile.runcall, operator.invoke
    with mock.patch.object(operator, "invoke", lambda self, context, event: run(invoke, self, context, event)):
        yield from ui.drag_mouse(start, (start[0] + 130, start[1] + 60), between=lambda step: ui.pause(0.1))
    called = str([entry.code for entry in profile.getstats()])
    assert "draw_handler_add" in called and "foreach_get" not in called and "find_pressed" not in called, called
    assert len(grab.handles()) == 1, ui.reports()
    yield from ui.wait_until(grab.is_at_rest, "the mesh has followed")
    yield from ui.screenshot("grab_1_dragged")
    pulled = grab.seen()
    assert np.abs(pulled - rest).max() > 0.5
    assert np.abs(pulled - rest)[rest[:, 2] < -1.0].max() == 0.0
    assert bpy.context.object == grab.ball() and bpy.context.selected_objects == [grab.handles()[0].control]

    yield from ui.undo()
    assert len(grab.handles()) == 0 and len(bpy.data.objects) == 1 and len(grab.ball().vertex_groups) == 0
    assert np.abs(grab.seen() - rest).max() < 1e-6
    yield from ui.redo()
    yield from ui.wait_until(grab.is_at_rest, "the redo has followed")
    assert np.abs(grab.seen() - pulled).max() < 0.02

    # A click on the handle selects it, a drag moves it, and it makes no second one.
    meshes.activate(grab.ball())
    seen = ui.project(grab.handles()[0].control.matrix_world.translation)
    yield from ui.click(*seen)
    assert bpy.context.object == grab.handles()[0].control and grab.handles()[0].control.select_get()
    yield from grab.drag(ui, seen, -60, 0)
    assert len(grab.handles()) == 1 and np.abs(grab.seen() - pulled).max() > 0.2

    # A second handle, without leaving Object Mode.
    start = ui.project(grab.front(x=-1.2, z=-0.5))
    yield from grab.drag(ui, start, -90, -40)
    assert len(grab.handles()) == 2
    yield from ui.screenshot("grab_2_second_handle")


def escape_takes_all_back(ui):
    yield from grab.set_up(ui)
    rest = grab.seen()
    start = ui.project(grab.front(z=1.0))
    yield from grab.drag_open(ui, start, 100, 0)
    assert len(grab.handles()) == 1
    yield from grab.escape(ui)
    obj = grab.ball()
    assert len(grab.handles()) == 0 and len(obj.vertex_groups) == 0 and obj.data.shape_keys is None
    assert len(bpy.data.objects) == 1 and not obj.meanvalue.live and obj.meanvalue.roi_group == ""
    assert np.array_equal(grab.seen(), rest)
    assert bpy.context.object == obj and ui.status_text() is None

    # Of a handle that is there only the drag is taken back.
    yield from grab.drag(ui, start, 60, 0)
    pulled = grab.seen()
    seen = ui.project(grab.handles()[0].control.matrix_world.translation)
    yield from grab.drag_open(ui, seen, 0, 80)
    ui._send('RIGHTMOUSE', 'PRESS')
    yield
    ui._send('LEFTMOUSE', 'RELEASE')
    yield from ui.wait_until(grab.is_at_rest, "the mesh is back")
    assert len(grab.handles()) == 1 and np.abs(grab.seen() - pulled).max() < 5e-3


def a_limb_is_suggested_and_shown_before_the_press(ui):
    """A ball with an arm, whose end is 3.7 from where it begins: so far goes Size, until the artist changes it."""
    arm = [(0.3 * min(1.0, 0.2 + 2.0 * way), 6.0 - way) for way in np.linspace(0.0, 4.0, 60)]
    body = [(2.0 * np.sin(turn), 2.0 * np.cos(turn)) for turn in np.linspace(0.2, np.pi - 0.1, 30)]
    angles = np.linspace(0.0, 2.0 * np.pi, 32, endpoint=False)
    places = [(-x, radius * np.sin(a), radius * np.cos(a)) for radius, x in arm + body for a in angles]
    meshes.make_object(places, rings.quads(90, 32).tolist(), "Ball")
    ui.remember()
    yield from grab.look_along_y(ui)
    whole = np.linalg.norm(np.ptp(places, axis=0))
    yield from ui.move_mouse(*ui.project((0.0, -1.9, 0.0)))
    yield from ui.pause(1.0)
    yield from ui.screenshot("grab_hover_body")
    start = ui.project((-5.7, -0.3, 0.0))  # away from the sidebar
    hover = installed.part("posing.operators.tool_choice")
    yield from ui.move_mouse(*start)
    yield from ui.wait_until(lambda: hover._found is not None and hover._found.place.x < -5.0, "it is shown")
    assert abs(hover._found.size * whole - 3.7) < 0.6, hover._found.size * whole
    yield from ui.screenshot("grab_hover_arm")
    body, arm = (ui.picture(f"grab_hover_{name}")[..., :3] for name in ("body", "arm"))
    x, y = ui.project((-5.0, -0.3, 0.0))
    assert (arm - body)[y, x, 2] > (arm - body)[y, x, 0] + 0.05, "the arm is tinted"
    yield from grab.drag_open(ui, start, 0, 60)
    yield from grab.turn_wheel(ui, 'WHEELDOWNMOUSE', 1)
    assert hover._found is None
    ui._send('LEFTMOUSE', 'RELEASE')
    yield from ui.wait_until(grab.is_at_rest, "the arm has followed")
    assert abs(grab.handles()[0].size * 1.15 * whole - 3.7) < 0.6, grab.handles()[0].size * whole
    assert abs(grab.tool_settings().size - 0.2) < 1e-6, grab.tool_settings().size
    yield from ui.undo()
    grab.tool_settings().size = 0.1
    yield from grab.drag(ui, start, 0, 60)
    assert abs(grab.handles()[0].size - 0.1) < 1e-6


def the_wheel_changes_the_size(ui):
    yield from grab.set_up(ui)
    grab.tool_settings().size = 0.22  # the artist's own
    start = ui.project(grab.front(z=0.5))
    yield from grab.drag_open(ui, start, 90, 60)
    yield from ui.pause(0.5)
    yield from ui.screenshot("grab_3_size_before")
    before = grab.region_size()
    yield from grab.turn_wheel(ui, 'WHEELUPMOUSE', 5)
    assert grab.region_size() > 2 * before
    yield from ui.wait_until(grab.is_at_rest, "the mesh follows with the new size")
    yield from ui.screenshot("grab_4_size_grown")
    yield from grab.turn_wheel(ui, 'LEFT_BRACKET', 9)
    assert grab.region_size() < before
    ui._send('LEFTMOUSE', 'RELEASE')
    yield from ui.wait_until(grab.is_at_rest, "the drag has ended")
    yield from ui.screenshot("grab_5_size_shrunk")
    assert abs(grab.tool_settings().size - 0.22 * 1.15**-4) < 1e-3

    # Of the handle that is there, the same way.
    before = grab.region_size()
    seen = ui.project(grab.handles()[0].control.matrix_world.translation)
    yield from grab.drag_open(ui, seen, 30, 0)
    yield from grab.turn_wheel(ui, 'WHEELUPMOUSE', 6)
    grown = grab.region_size()
    assert grown > 2 * before
    yield from grab.escape(ui)
    assert grab.region_size() == before
    yield from grab.drag_open(ui, seen, 30, 0)
    yield from grab.turn_wheel(ui, 'WHEELUPMOUSE', 6)
    for _ in range(3):
        yield from ui.key('WHEELDOWNMOUSE')
    ui._send('LEFTMOUSE', 'RELEASE')
    yield from ui.wait_until(grab.is_at_rest, "the second drag has ended")
    assert before < grab.region_size() < grown


def the_control_is_moved_and_deleted_while_the_mesh_is_active(ui):
    yield from grab.set_up(ui)
    start = ui.project(grab.front(z=1.0))
    yield from grab.drag(ui, start, 60, 60)
    control, pulled = grab.handles()[0].control, grab.seen()
    place = control.location.copy()
    x, y = start[0] + 60, start[1] + 60
    yield from ui.move_mouse(x, y)
    yield from ui.key('G')
    yield from ui.move_mouse(x + 40, y)
    yield from ui.key('RET')
    yield from ui.wait_until(grab.is_at_rest, "the mesh has followed G")
    assert (grab.handles()[0].control.location - place).length > 0.1 and grab.ball().location.length == 0.0
    assert np.abs(grab.seen() - pulled).max() > 0.1
    yield from ui.key('X')
    yield from ui.key('RET')
    yield from ui.pause(1.0)
    assert "Ball" in bpy.data.objects and bpy.context.object == grab.ball()
    yield from ui.undo()
    assert grab.handles()[0].control is not None


def shift_click_pins(ui):
    yield from grab.set_up(ui)
    rest = grab.seen()
    pinned = ui.project(grab.front(x=0.5))
    yield from ui.click(*pinned, shift=True)
    assert [handle.follows for handle in grab.handles()] == ['REST'], ui.reports()
    start = ui.project(grab.front(x=-0.3))
    yield from grab.drag(ui, start, -100, 40)
    members = steps.held(grab.ball(), grab.handles()[0].name)
    assert np.abs(grab.seen() - rest)[members].max() == 0.0
    yield from ui.screenshot("grab_6_pin")
    yield from ui.drag_mouse(pinned, (pinned[0] + 50, pinned[1]))
    assert any("is pinned here" in line for line in ui.reports()), ui.reports()
    yield from ui.click(*pinned, shift=True)
    assert [handle.follows for handle in grab.handles()] == ['CONTROL']
    yield from ui.wait_until(grab.is_at_rest, "the mesh has followed without the pin")


def finish(ui):
    yield from grab.set_up(ui)
    start = ui.project(grab.front(z=1.2))
    yield from grab.drag(ui, start, 100, 60)
    pulled = grab.seen()
    yield from ui.invoke("meanvalue.finish")
    yield from ui.pause(0.3)
    obj = grab.ball()
    assert len(grab.handles()) == 0 and len(obj.vertex_groups) == 0 and len(bpy.data.objects) == 1
    assert np.abs(grab.seen() - pulled).max() < 5e-3
    assert [key.name for key in obj.data.shape_keys.key_blocks] == ["Basis", "Pose"]
    yield from ui.screenshot("grab_8_finished")
    yield from ui.undo()
    assert len(grab.handles()) == 1 and grab.handles()[0].control is not None
    yield from ui.wait_until(grab.is_at_rest, "it is live again")
    assert np.abs(grab.seen() - pulled).max() < 5e-3


def alt_and_the_left_button_look_around(ui):
    """In a keymap that turns the view so, while the tool is active and while a place is picked."""
    yield from grab.set_up(ui)
    keymap = bpy.context.window_manager.keyconfigs.addon.keymaps.new(name="3D View", space_type='VIEW_3D')
    item = keymap.keymap_items.new("view3d.rotate", 'LEFTMOUSE', 'PRESS', alt=True)
    start, seen = ui.project(grab.front(z=0.5)), view.area().spaces.active.region_3d
    for operator in (None, "meanvalue.pick_wrap_pairs"):
        if operator:
            grab.make_ball(ui, "Other", (6.0, 0.0, 0.0))
            meshes.activate(grab.ball())
            bpy.data.objects["Other"].select_set(True)
            yield from ui.invoke(operator)
        before = seen.view_rotation.copy()
        yield from ui.move_mouse(*start)
        ui._send('LEFTMOUSE', 'PRESS', {"alt": True})
        yield
        yield from ui._glide((start[0] + 80, start[1] + 30), 4, None)
        ui._send('LEFTMOUSE', 'RELEASE')
        yield
        assert before.rotation_difference(seen.view_rotation).angle > 0.05, operator
        assert not grab.handles() and len(grab.ball().meanvalue.wrap.pairs) == 0
    assert ui.status_text() is not None, "it goes on"
    yield from ui.key('RET')
    keymap.keymap_items.remove(item)


def a_press_beside_the_mesh_leaves_all_as_it_is(ui):
    yield from grab.set_up(ui)
    start = ui.project(grab.front(z=1.2))
    yield from ui.click(*start)
    assert len(grab.handles()) == 0 and any("Press and drag" in line for line in ui.reports())
    x, y = ui.project((0.0, 0.0, 2.0))
    yield from ui.drag_mouse((x, y + 60), (x + 60, y + 60))
    assert len(grab.handles()) == 0 and ui.status_text() is None
    grab.ball().data.clear_geometry()
    grab.ball().data.from_pydata([(-2.0, -2.0, 0.0), (2.0, -2.0, 0.0)], [(0, 1)], [])
    yield from ui.click(*start)
    assert any("has no faces" in line for line in ui.reports()), ui.reports()


def picture_of_the_guide(ui):
    """A head whose ear is pulled, with quads, loose parts and a modifier that makes vertices."""
    bpy.ops.mesh.primitive_monkey_add(size=4.0)
    obj = bpy.context.object
    obj.name = "Ball"
    shape = obj.modifiers.new("Finer", 'SUBSURF')
    shape.levels = 2
    bpy.ops.object.modifier_apply(modifier=shape.name)
    obj.modifiers.new("Smooth", 'SUBSURF').levels = 1
    for polygon in obj.data.polygons:
        polygon.use_smooth = True
    ui.remember()
    yield from grab.look_along_y(ui)
    pinned = ui.project((0.0, -1.5, -1.4))
    yield from ui.click(*pinned, shift=True)
    start = ui.project((-2.5, 0.0, 0.75))  # the ear away from the sidebar and the buttons beside it
    yield from grab.drag_open(ui, start, -20, 120)
    yield from ui.wait_until(grab.is_at_rest, "the ear has followed")
    yield from ui.screenshot("grab_9_guide")
    during = grab.seen()
    ui._send('LEFTMOUSE', 'RELEASE')
    yield
    assert [handle.follows for handle in grab.handles()] == ['REST', 'CONTROL'], ui.reports()
    yield from ui.wait_until(grab.is_at_rest, "the drag has ended")
    assert np.abs(grab.seen() - during).max() < 0.01
