# SPDX-License-Identifier: GPL-3.0-or-later
"""The Grab tool on images of a mirror, on other objects, on what is linked, in Local View."""

import pathlib
import tempfile

import bmesh
import bpy
import numpy as np
from harness import grab, view
from support import libraries, meshes, steps
from support.interface import is_settled


def an_image_of_a_mirror_is_dragged(ui):
    grab.make_ball(ui)
    steps.edit_mesh(grab.ball(), _cut_off_the_left)
    grab.ball().modifiers.new("Mirror", 'MIRROR')
    ui.remember()
    yield from grab.look_along_y(ui)
    start = ui.project(grab.front(x=-1.2, z=0.3))
    end = (start[0] - 90, start[1] + 20)
    yield from ui.drag_mouse(start, end, between=lambda step: ui.pause(0.1))
    assert len(grab.handles()) == 1, ui.reports()
    yield from ui.wait_until(grab.is_at_rest, "the mesh has followed")
    yield from ui.screenshot("grab_image_dragged")
    place = grab.handles()[0].control.matrix_world.translation
    assert place.x > 1.2
    seen = ui.project((-place.x, place.y, place.z))
    assert np.abs(np.subtract(seen, end)).max() < 30, (seen, end)  # where the vertex was pressed, to an edge
    # What an Array shows is nobody's.
    array = grab.ball().modifiers.new("Array", 'ARRAY')
    array.relative_offset_displace = (0.0, 0.0, 1.2)
    ui.frame_all()
    yield from ui.pause(0.5)
    yield from ui.click(*ui.project((1.0, -1.7, 5.0)))
    assert any("no surface of its own" in line for line in ui.reports()), ui.reports()
    assert len(grab.handles()) == 1


def _cut_off_the_left(mesh):
    bmesh.ops.delete(mesh, geom=[vertex for vertex in mesh.verts if vertex.co.x < -1e-3], context='VERTS')


def another_object_is_grabbed_by_the_same_press(ui):
    yield from grab.set_up(ui)
    grab.make_ball(ui, "Beside", (6.0, 0.0, 0.0))
    bpy.ops.mesh.primitive_cube_add(size=0.4, location=grab.front(z=1.2))
    bpy.context.object.parent = grab.ball()  # worn: a first press on it grabs what it is on
    meshes.activate(grab.ball())
    ui.remember()
    ui.frame_all()
    yield from ui.pause(0.5)
    yield from grab.drag(ui, ui.project(grab.front(z=1.2)), 30, 30)
    start = ui.project((6.0, -2.0, 0.3))
    yield from grab.drag_open(ui, start, 40, 0)
    beside = bpy.context.object
    assert beside.name == "Beside" and len(beside.meanvalue.handles) == 1, ui.reports()
    yield from grab.escape(ui)
    assert bpy.context.object == grab.ball() and len(bpy.data.objects["Beside"].meanvalue.handles) == 0
    yield from ui.drag_mouse(start, (start[0] + 40, start[1]))
    beside = bpy.context.object
    assert beside.name == "Beside" and len(beside.meanvalue.handles) == 1, ui.reports()
    assert len(grab.handles()) == 1


def wire_and_what_cannot_be_selected_are_passed_through(ui):
    yield from grab.set_up(ui)
    grab.make_ball(ui, "Front", (0.0, -5.0, 0.0))
    front, held = bpy.data.objects["Front"], bpy.data.collections.new("Held")
    bpy.context.scene.collection.children.link(held)
    ui.remember()
    start = ui.project((0.0, -7.0, 0.5))
    for count, (owner, name, value) in enumerate(
        [(front, "display_type", 'WIRE'), (front, "hide_select", True), (held, "hide_select", True)]
    ):
        if owner == held:
            for collection in front.users_collection:
                collection.objects.unlink(front)
            held.objects.link(front)
        former = getattr(owner, name)
        setattr(owner, name, value)
        bpy.context.view_layer.objects.active = None
        yield from ui.drag_mouse((start[0] + 30 * count, start[1]), (start[0] + 30 * count, start[1] + 40))
        assert len(grab.handles()) > 0 and len(front.meanvalue.handles) == 0, (name, ui.reports())
        setattr(owner, name, former)
    bpy.context.view_layer.objects.active = None
    yield from ui.drag_mouse(start, (start[0] + 50, start[1]))
    assert len(front.meanvalue.handles) == 1, ui.reports()


def what_is_linked_is_refused_and_what_is_overridden_is_posed_by_an_object_beside(ui):
    yield from grab.set_up(ui)
    obj = grab.ball()
    obj.name = obj.data.name = "Linked"
    linked = libraries.linked(pathlib.Path(tempfile.mkdtemp()), obj, "objects")
    bpy.data.objects.remove(obj)
    override = linked.override_create()
    override.location.x = 6.0
    bpy.context.collection.objects.link(override)
    bpy.context.view_layer.update()
    ui.remember()
    ui.frame_all()
    yield from ui.pause(0.5)
    start = ui.project((0.0, -2.0, 0.3))
    yield from ui.drag_mouse(start, (start[0] + 40, start[1]))
    yield from ui.click(*start, shift=True)
    assert not linked.meanvalue.handles and linked.data.shape_keys is None and len(bpy.data.objects) == 2
    assert any("'Linked' is linked from another file. Make it an override" in line for line in ui.reports())
    start, before = ui.project((6.0, -2.0, 0.3)), meshes.seen(override)
    yield from grab.drag_open(ui, start, 40, 0)
    assert override.children
    yield from grab.escape(ui)
    assert len(bpy.data.objects) == 2 and not bpy.data.node_groups
    yield from ui.drag_mouse(start, (start[0] + 40, start[1]))
    (posed,) = (child for child in override.children if child.type == 'MESH')
    yield from ui.wait_until(lambda: is_settled(posed), "the mesh has followed")
    assert len(posed.meanvalue.handles) == 1 and not override.meanvalue.handles
    assert bpy.context.object == override and np.abs(meshes.seen(override) - before).max() > 0.1
    yield from ui.undo()
    assert len(bpy.data.objects) == 2 and np.array_equal(meshes.seen(bpy.data.objects["Linked", None]), before)


def local_view(ui):
    yield from grab.set_up(ui)
    grab.make_ball(ui, "Front", (0.0, -5.0, 0.0))
    meshes.activate(grab.ball())
    ui.remember()
    grab.ball().meanvalue.show_overlay = True
    with view.override():
        bpy.ops.view3d.localview()
    yield from ui.pause(1.5)
    start = ui.project(grab.front(z=0.8))
    yield from ui.drag_mouse(start, (start[0] + 80, start[1] + 40))
    assert len(grab.handles()) == 1, ui.reports()
    yield from ui.wait_until(grab.is_at_rest, "the mesh has followed")
    control = grab.handles()[0].control
    assert control.visible_get(viewport=view.area().spaces.active)
    yield from ui.screenshot("grab_7_local_view")
    with view.override():
        bpy.ops.view3d.localview()
    yield from ui.pause(1.5)
    # Outside of it the other ball is in front.
    meshes.activate(grab.ball())
    start = ui.project((0.0, -7.0, 0.5))
    yield from ui.drag_mouse(start, (start[0] + 50, start[1]))
    front = bpy.data.objects["Front"]
    assert any("'Front' is in front of 'Ball' here" in line for line in ui.reports()), ui.reports()
    assert bpy.context.object == grab.ball() and len(front.meanvalue.handles) == 0
    # What is behind is hidden: nobody can mean that.
    grab.ball().hide_set(True)
    ui.remember()
    yield from ui.drag_mouse(start, (start[0] + 50, start[1]))
    assert len(bpy.data.objects["Front"].meanvalue.handles) == 1
    yield from ui.undo()
    grab.ball().hide_set(False)
    yield from ui.click(*start)
    assert bpy.context.object.name == "Front"
    yield from ui.drag_mouse(start, (start[0] + 50, start[1]))
    assert len(bpy.data.objects["Front"].meanvalue.handles) == 1
