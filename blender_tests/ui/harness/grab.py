# SPDX-License-Identifier: GPL-3.0-or-later
"""The Grab tool on a ball: what its scenarios do and look at."""

import bpy
import numpy as np
from support import meshes
from support.interface import is_settled

from . import view

TOOL = "meanvalue.grab"


def ball():
    """Looked up on every call: references do not survive undo."""
    return bpy.data.objects["Ball"]


def handles():
    return ball().meanvalue.handles


def is_at_rest():
    return is_settled(ball())


def seen():
    return meshes.seen(ball())


def make_ball(ui, name="Ball", at=(0.0, 0.0, 0.0)):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=32, radius=2.0, location=at)
    obj = bpy.context.object
    obj.name = obj.data.name = name
    for polygon in obj.data.polygons:
        polygon.use_smooth = True
    meshes.activate(obj)


def set_up(ui):
    """A fresh ball, and as look_along_y()."""
    make_ball(ui)
    ui.remember()
    yield from look_along_y(ui)


def look_along_y(ui):
    """With the panel open, and the tool chosen."""
    yield from ui.open_tab("Mean-Value")
    yield from ui.move_mouse(*view.centre())
    yield from ui.key('NUMPAD_1')
    seen = view.area().spaces.active.region_3d
    yield from ui.wait_until(lambda: seen.view_perspective == 'ORTHO', "the view has turned")
    ui.frame_all()
    yield from ui.pause(0.5)
    with view.override():
        bpy.ops.wm.tool_set_by_id(name=TOOL)


def front(x=0.0, z=0.0):
    """A place on the side of the ball that is seen."""
    return x, -np.sqrt(4.0 - x * x - z * z), z


def drag(ui, start, dx, dy, between=None):
    """With the left button, until the mesh has followed. Returns where it ended."""
    end = start[0] + dx, start[1] + dy
    yield from ui.drag_mouse(start, end, between=between)
    yield from ui.wait_until(is_at_rest, "the mesh has followed")
    return end


def drag_open(ui, start, dx, dy):
    """A drag with the button left down."""
    yield from ui.move_mouse(*start)
    ui._send('LEFTMOUSE', 'PRESS')
    yield
    yield from ui._glide((start[0] + dx, start[1] + dy), 4, None)


def turn_wheel(ui, key, times):
    for _ in range(times):
        yield from ui.key(key)
    yield from ui.pause(0.5)


def escape(ui):
    """Of a drag_open()."""
    yield from ui.key('ESC')
    ui._send('LEFTMOUSE', 'RELEASE')
    yield from ui.pause(0.3)


def tool_settings():
    with view.override():
        return bpy.context.workspace.tools.from_space_view3d_mode('OBJECT').operator_properties(TOOL)


def region_size():
    group = ball().vertex_groups[ball().meanvalue.roi_group].index
    return sum(any(element.group == group for element in vertex.groups) for vertex in ball().data.vertices)
