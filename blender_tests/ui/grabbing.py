# SPDX-License-Identifier: GPL-3.0-or-later
"""The Grab tool, by the mouse: from a fresh mesh to a drag, its size, pins, Local View, Finish."""

import bpy
import numpy as np
from harness import view
from support import meshes, steps
from support.interface import is_settled

TOOL = "meanvalue.grab"


def ball():
    """Looked up on every call: references do not survive undo."""
    return bpy.data.objects["Ball"]


def handles():
    return ball().meanvalue.handles


def _settled():
    return is_settled(ball())


def _seen():
    return meshes.seen(ball())


def _make_ball(ui, name="Ball", at=(0.0, 0.0, 0.0)):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=32, radius=2.0, location=at)
    obj = bpy.context.object
    obj.name = obj.data.name = name
    for polygon in obj.data.polygons:
        polygon.use_smooth = True
    meshes.activate(obj)


def _set_up(ui):
    """A fresh ball and a look along y."""
    _make_ball(ui)
    ui.remember()
    yield from _look_along_y(ui)


def _look_along_y(ui):
    """With the panel open."""
    yield from ui.open_tab("Mean-Value")
    yield from ui.move_mouse(*view.centre())
    yield from ui.key('NUMPAD_1')
    seen = view.area().spaces.active.region_3d
    yield from ui.wait_until(lambda: seen.view_perspective == 'ORTHO', "the view has turned")
    ui.frame_all()
    yield from ui.pause(0.5)


def _choose_tool():
    """What a click at its button in the toolbar does."""
    with view.override():
        bpy.ops.wm.tool_set_by_id(name=TOOL)


def _front(x=0.0, z=0.0):
    """A place on the side of the ball that is seen."""
    return x, -np.sqrt(4.0 - x * x - z * z), z


def three_acts_from_a_fresh_mesh(ui):
    yield from _set_up(ui)
    rest = _seen()
    _choose_tool()
    start = ui.project(_front(z=1.2))
    yield from ui.drag_mouse(start, (start[0] + 130, start[1] + 60), between=lambda step: ui.pause(0.1))
    assert len(handles()) == 1, ui.reports()
    yield from ui.wait_until(_settled, "the mesh has followed")
    yield from ui.screenshot("grab_1_dragged")
    pulled = _seen()
    assert np.abs(pulled - rest).max() > 0.5
    assert np.abs(pulled - rest)[rest[:, 2] < -1.0].max() == 0.0
    assert bpy.context.object == ball() and bpy.context.selected_objects == [handles()[0].control]
    assert any("Handle made." in line for line in ui.reports()), ui.reports()

    yield from ui.undo()
    assert len(handles()) == 0 and len(bpy.data.objects) == 1 and len(ball().vertex_groups) == 0
    assert np.abs(_seen() - rest).max() < 1e-6
    yield from ui.redo()
    yield from ui.wait_until(_settled, "the redo has followed")
    assert np.abs(_seen() - pulled).max() < 0.02

    # A click on the handle selects it, a drag moves it, and it makes no second one.
    meshes.activate(ball())
    seen = ui.project(handles()[0].control.matrix_world.translation)
    yield from ui.click(*seen)
    assert bpy.context.object == handles()[0].control and handles()[0].control.select_get()
    yield from ui.drag_mouse(seen, (seen[0] - 60, seen[1]))
    yield from ui.wait_until(_settled, "the second drag has followed")
    assert len(handles()) == 1 and np.abs(_seen() - pulled).max() > 0.2

    # A second handle, without leaving Object Mode.
    start = ui.project(_front(x=-1.2, z=-0.5))
    yield from ui.drag_mouse(start, (start[0] - 90, start[1] - 40))
    yield from ui.wait_until(_settled, "the second handle has followed")
    assert len(handles()) == 2
    yield from ui.screenshot("grab_2_second_handle")


def an_image_of_a_mirror_is_dragged(ui):
    _make_ball(ui)
    steps.edit_mesh(ball(), _cut_off_the_left)
    ball().modifiers.new("Mirror", 'MIRROR')
    ui.remember()
    yield from _look_along_y(ui)
    _choose_tool()
    start = ui.project(_front(x=-1.2, z=0.3))
    end = (start[0] - 90, start[1] + 20)
    yield from ui.drag_mouse(start, end, between=lambda step: ui.pause(0.1))
    assert len(handles()) == 1, ui.reports()
    yield from ui.wait_until(_settled, "the mesh has followed")
    yield from ui.screenshot("grab_image_dragged")
    place = handles()[0].control.matrix_world.translation
    assert place.x > 1.2
    seen = ui.project((-place.x, place.y, place.z))
    assert np.abs(np.subtract(seen, end)).max() < 30, (seen, end)  # where the vertex was pressed, to an edge
    # What an Array shows is nobody's.
    array = ball().modifiers.new("Array", 'ARRAY')
    array.relative_offset_displace = (0.0, 0.0, 1.2)
    ui.frame_all()
    yield from ui.pause(0.5)
    yield from ui.click(*ui.project((1.0, -1.7, 5.0)))
    assert any("no surface of its own" in line for line in ui.reports()), ui.reports()
    assert len(handles()) == 1


def _cut_off_the_left(mesh):
    import bmesh

    bmesh.ops.delete(mesh, geom=[vertex for vertex in mesh.verts if vertex.co.x < -1e-3], context='VERTS')


def escape_takes_all_back(ui):
    yield from _set_up(ui)
    rest = _seen()
    _choose_tool()
    start = ui.project(_front(z=1.0))
    yield from _drag_open(ui, start, (start[0] + 100, start[1]))
    assert len(handles()) == 1
    yield from ui.key('ESC')
    ui._send('LEFTMOUSE', 'RELEASE')
    yield from ui.pause(0.3)
    obj = ball()
    assert len(handles()) == 0 and len(obj.vertex_groups) == 0 and obj.data.shape_keys is None
    assert len(bpy.data.objects) == 1 and not obj.meanvalue.live and obj.meanvalue.roi_group == ""
    assert np.array_equal(_seen(), rest)
    assert bpy.context.object == obj and ui.status_text() is None

    # Of a handle that is there only the drag is taken back.
    yield from ui.drag_mouse(start, (start[0] + 60, start[1]))
    yield from ui.wait_until(_settled, "the mesh has followed")
    pulled = _seen()
    seen = ui.project(handles()[0].control.matrix_world.translation)
    yield from _drag_open(ui, seen, (seen[0], seen[1] + 80))
    ui._send('RIGHTMOUSE', 'PRESS')
    yield
    ui._send('LEFTMOUSE', 'RELEASE')
    yield from ui.wait_until(_settled, "the mesh is back")
    assert len(handles()) == 1 and np.abs(_seen() - pulled).max() < 5e-3


def the_wheel_changes_the_size(ui):
    yield from _set_up(ui)
    _choose_tool()
    start = ui.project(_front(z=0.5))
    yield from _drag_open(ui, start, (start[0] + 90, start[1] + 60))
    yield from ui.pause(0.5)
    yield from ui.screenshot("grab_3_size_before")
    before = _region_size()
    for _ in range(5):
        yield from ui.key('WHEELUPMOUSE')
    yield from ui.pause(0.5)
    assert _region_size() > 2 * before
    yield from ui.wait_until(_settled, "the mesh follows with the new size")
    yield from ui.screenshot("grab_4_size_grown")
    for _ in range(9):
        yield from ui.key('LEFT_BRACKET')
    yield from ui.pause(0.5)
    assert _region_size() < before
    ui._send('LEFTMOUSE', 'RELEASE')
    yield from ui.wait_until(_settled, "the drag has ended")
    yield from ui.screenshot("grab_5_size_shrunk")
    with view.override():
        tool = bpy.context.workspace.tools.from_space_view3d_mode('OBJECT')
        assert abs(tool.operator_properties(TOOL).size - 0.2 * 1.15**-4) < 1e-3

    # Of the handle that is there, the same way.
    before = _region_size()
    seen = ui.project(handles()[0].control.matrix_world.translation)
    yield from _drag_open(ui, seen, (seen[0] + 30, seen[1]))
    for _ in range(6):
        yield from ui.key('WHEELUPMOUSE')
    yield from ui.pause(0.5)
    grown = _region_size()
    assert grown > 2 * before
    yield from ui.key('ESC')
    ui._send('LEFTMOUSE', 'RELEASE')
    yield from ui.pause(0.3)
    assert _region_size() == before
    yield from _drag_open(ui, seen, (seen[0] + 30, seen[1]))
    for _ in range(6):
        yield from ui.key('WHEELUPMOUSE')
    yield from ui.pause(0.5)
    for _ in range(3):
        yield from ui.key('WHEELDOWNMOUSE')
    ui._send('LEFTMOUSE', 'RELEASE')
    yield from ui.wait_until(_settled, "the second drag has ended")
    assert before < _region_size() < grown


def the_control_is_moved_and_deleted_while_the_mesh_is_active(ui):
    yield from _set_up(ui)
    _choose_tool()
    start = ui.project(_front(z=1.0))
    yield from ui.drag_mouse(start, (start[0] + 60, start[1] + 60))
    yield from ui.wait_until(_settled, "the mesh has followed")
    control, pulled = handles()[0].control, _seen()
    place = control.location.copy()
    x, y = start[0] + 60, start[1] + 60
    yield from ui.move_mouse(x, y)
    yield from ui.key('G')
    yield from ui.move_mouse(x + 40, y)
    yield from ui.key('RET')
    yield from ui.wait_until(_settled, "the mesh has followed G")
    assert (handles()[0].control.location - place).length > 0.1 and ball().location.length == 0.0
    assert np.abs(_seen() - pulled).max() > 0.1
    yield from ui.key('X')
    yield from ui.key('RET')
    yield from ui.pause(1.0)
    assert "Ball" in bpy.data.objects and bpy.context.object == ball()
    yield from ui.undo()
    assert handles()[0].control is not None


def another_object_is_grabbed_by_the_same_press(ui):
    yield from _set_up(ui)
    _make_ball(ui, "Beside", (6.0, 0.0, 0.0))
    meshes.activate(ball())
    ui.remember()
    ui.frame_all()
    yield from ui.pause(0.5)
    _choose_tool()
    start = ui.project(_front(z=1.2))
    yield from ui.drag_mouse(start, (start[0] + 30, start[1] + 30))
    yield from ui.wait_until(_settled, "the mesh has followed")
    start = ui.project((6.0, -2.0, 0.3))
    yield from _drag_open(ui, start, (start[0] + 40, start[1]))
    beside = bpy.data.objects["Beside"]
    assert bpy.context.object == beside and len(beside.meanvalue.handles) == 1, ui.reports()
    yield from ui.key('ESC')
    ui._send('LEFTMOUSE', 'RELEASE')
    yield from ui.pause(0.3)
    beside = bpy.data.objects["Beside"]
    assert bpy.context.object == ball() and len(beside.meanvalue.handles) == 0
    yield from ui.drag_mouse(start, (start[0] + 40, start[1]))
    beside = bpy.data.objects["Beside"]
    assert bpy.context.object == beside and len(beside.meanvalue.handles) == 1, ui.reports()
    assert len(handles()) == 1


def what_is_linked_is_refused_before_anything_is_written(ui):
    import pathlib
    import tempfile

    yield from _set_up(ui)
    obj = ball()
    with tempfile.TemporaryDirectory() as folder:
        path = str(pathlib.Path(folder) / "library.blend")
        obj.name = obj.data.name = "Linked"
        bpy.data.libraries.write(path, {obj})
        bpy.data.objects.remove(obj)
        with bpy.data.libraries.load(path, link=True) as (_source, wanted):
            wanted.objects = ["Linked"]
    linked = wanted.objects[0]
    bpy.context.collection.objects.link(linked)
    local = bpy.data.objects.new("Local", linked.data)
    local.location.x = 6.0
    bpy.context.collection.objects.link(local)
    override = linked.override_create()
    override.location.x = 12.0
    bpy.context.collection.objects.link(override)
    bpy.context.view_layer.update()
    ui.remember()
    ui.frame_all()
    yield from ui.pause(0.5)
    _choose_tool()
    for each in (linked, local, override):
        for active in (each, None):
            bpy.context.view_layer.objects.active = active
            start = ui.project((each.matrix_world.translation.x, -2.0, 0.3))
            yield from ui.drag_mouse(start, (start[0] + 40, start[1]))
            yield from ui.click(*start, shift=True)
            assert not each.meanvalue.handles and not each.meanvalue.live and not each.vertex_groups
            assert each.data.shape_keys is None and len(bpy.data.objects) == 3
    assert sum("'Linked' is linked" in line or "The mesh of 'Local'" in line for line in ui.reports()) > 0


def shift_click_pins(ui):
    yield from _set_up(ui)
    rest = _seen()
    _choose_tool()
    pinned = ui.project(_front(x=0.5))
    yield from ui.click(*pinned, shift=True)
    assert [handle.follows for handle in handles()] == ['REST'], ui.reports()
    start = ui.project(_front(x=-0.3))
    yield from ui.drag_mouse(start, (start[0] - 100, start[1] + 40))
    yield from ui.wait_until(_settled, "the mesh has followed")
    members = handles_of("Pin")
    assert np.abs(_seen() - rest)[members].max() == 0.0
    yield from ui.screenshot("grab_6_pin")
    yield from ui.drag_mouse(pinned, (pinned[0] + 50, pinned[1]))
    assert any("is pinned here" in line for line in ui.reports()), ui.reports()
    yield from ui.click(*pinned, shift=True)
    assert [handle.follows for handle in handles()] == ['CONTROL']
    yield from ui.wait_until(_settled, "the mesh has followed without the pin")


def local_view(ui):
    yield from _set_up(ui)
    _make_ball(ui, "Front", (0.0, -5.0, 0.0))
    meshes.activate(ball())
    ui.remember()
    _choose_tool()
    ball().meanvalue.show_overlay = True
    with view.override():
        bpy.ops.view3d.localview()
    yield from ui.pause(1.5)
    start = ui.project(_front(z=0.8))
    yield from ui.drag_mouse(start, (start[0] + 80, start[1] + 40))
    assert len(handles()) == 1, ui.reports()
    yield from ui.wait_until(_settled, "the mesh has followed")
    control = handles()[0].control
    assert control.visible_get(viewport=view.area().spaces.active)
    yield from ui.screenshot("grab_7_local_view")
    with view.override():
        bpy.ops.view3d.localview()
    yield from ui.pause(1.5)
    # Outside of it the other ball is in front.
    meshes.activate(ball())
    start = ui.project((0.0, -7.0, 0.5))
    yield from ui.drag_mouse(start, (start[0] + 50, start[1]))
    front = bpy.data.objects["Front"]
    assert any("'Front' is in front of 'Ball' here" in line for line in ui.reports()), ui.reports()
    assert bpy.context.object == ball() and len(front.meanvalue.handles) == 0
    yield from ui.click(*start)
    assert bpy.context.object.name == "Front"
    yield from ui.drag_mouse(start, (start[0] + 50, start[1]))
    assert len(bpy.data.objects["Front"].meanvalue.handles) == 1


def finish(ui):
    yield from _set_up(ui)
    _choose_tool()
    start = ui.project(_front(z=1.2))
    yield from ui.drag_mouse(start, (start[0] + 100, start[1] + 60))
    yield from ui.wait_until(_settled, "the mesh has followed")
    pulled = _seen()
    yield from ui.invoke("meanvalue.finish")
    yield from ui.pause(0.3)
    obj = ball()
    assert len(handles()) == 0 and len(obj.vertex_groups) == 0 and len(bpy.data.objects) == 1
    assert np.abs(_seen() - pulled).max() < 5e-3
    assert [key.name for key in obj.data.shape_keys.key_blocks] == ["Basis", "Kept Pose"]
    yield from ui.screenshot("grab_8_finished")
    yield from ui.undo()
    assert len(handles()) == 1 and handles()[0].control is not None
    yield from ui.wait_until(_settled, "it is live again")
    assert np.abs(_seen() - pulled).max() < 5e-3


def a_press_beside_the_mesh_leaves_all_as_it_is(ui):
    yield from _set_up(ui)
    _choose_tool()
    start = ui.project(_front(z=1.2))
    yield from ui.click(*start)
    assert len(handles()) == 0 and any("Press and drag" in line for line in ui.reports())
    x, y = ui.project((0.0, 0.0, 2.0))
    yield from ui.drag_mouse((x, y + 60), (x + 60, y + 60))
    assert len(handles()) == 0 and ui.status_text() is None


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
    yield from _look_along_y(ui)
    _choose_tool()
    pinned = ui.project((0.0, -1.5, -1.4))
    yield from ui.click(*pinned, shift=True)
    start = ui.project((-2.5, 0.0, 0.75))  # the ear away from the sidebar and the buttons beside it
    yield from _drag_open(ui, start, (start[0] - 20, start[1] + 120))
    yield from ui.wait_until(_settled, "the ear has followed")
    yield from ui.screenshot("grab_9_guide")
    during = _seen()
    ui._send('LEFTMOUSE', 'RELEASE')
    yield
    assert [handle.follows for handle in handles()] == ['REST', 'CONTROL'], ui.reports()
    yield from ui.wait_until(_settled, "the drag has ended")
    assert np.abs(_seen() - during).max() < 0.01


def handles_of(name):
    group = ball().vertex_groups[name].index
    return [vertex.index for vertex in ball().data.vertices if any(element.group == group for element in vertex.groups)]


def _region_size():
    return len(handles_of(ball().meanvalue.roi_group))


def _drag_open(ui, start, end):
    """A drag with the button left down."""
    yield from ui.move_mouse(*start)
    ui._send('LEFTMOUSE', 'PRESS')
    yield
    yield from ui._glide(end, 4, None)
