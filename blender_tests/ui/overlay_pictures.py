# SPDX-License-Identifier: GPL-3.0-or-later
"""The overlay on every kind of view, the menus and the shortcuts: nothing is printed while it is drawn, and the
pictures are for looking at.

    ./dev test --only ui -k overlay_pictures
"""

import bpy
from harness import view
from support import handles, meshes, steps

SEGMENTS = 24


def _set_up(ui):
    """A posed tube with a pin, two handles and a region."""
    obj = meshes.tube(rings=25, segments=SEGMENTS)
    steps.list_anchors(obj, Bottom=range(SEGMENTS))
    for name, members in (("Middle", range(288, 312, 6)), ("Top", range(576, 600))):
        steps.add_handle(obj, name, members)
        meshes.activate(obj)
    bpy.ops.meanvalue.grow_region(distance=6.0)
    ui.remember()
    ui.frame_all()
    yield from ui.open_tab("Mean-Value")


def _shading(kind, show_xray):
    shading = view.area().spaces.active.shading
    shading.type = kind
    shading.show_xray = show_xray


def overlay_on_views(ui):
    yield from _set_up(ui)
    yield from ui.screenshot("overlay_01_region")
    control = handles.again().meanvalue.handles["Top"].control
    control.location.x += 3.0
    control.location.z -= 2.0
    bpy.context.view_layer.update()
    meshes.activate(control)
    yield from ui.screenshot("overlay_02_posed")
    _shading('SOLID', True)
    yield from ui.screenshot("overlay_03_xray")
    _shading('SOLID', False)
    handles.again().modifiers.new("Subdivision", 'SUBSURF')
    yield from ui.screenshot("overlay_04_subdivided")
    handles.again().modifiers.clear()
    meshes.activate(handles.again())
    bpy.ops.meanvalue.paint_region()
    yield from ui.screenshot("overlay_05_weight_paint")
    bpy.ops.meanvalue.paint_region()
    view.area().spaces.active.overlay.show_overlays = False
    yield from ui.screenshot("overlay_06_off")
    view.area().spaces.active.overlay.show_overlays = True
    handles.again().hide_set(True)
    yield from ui.screenshot("overlay_07_hidden")


def menus_and_shortcuts(ui):
    yield from _set_up(ui)
    meshes.activate(handles.again())
    yield from ui.move_mouse(*view.centre())
    yield from ui.key('F3')
    yield from ui.type("grow from")
    yield from ui.pause(0.5)
    yield from ui.screenshot("overlay_08_search")
    yield from ui.key('ESC')
    yield from ui.key('ESC')
    with view.override():
        bpy.ops.wm.call_menu('INVOKE_DEFAULT', name="MEANVALUE_MT_object")
    yield from ui.pause(0.3)
    yield from ui.screenshot("overlay_09_menu")
    yield from ui.key('ESC')
    was_live = handles.again().meanvalue.live
    yield from ui.move_mouse(*view.centre())
    yield from ui.key('L', alt=True)
    assert handles.again().meanvalue.live != was_live
