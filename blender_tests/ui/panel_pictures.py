# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel in each of its states: nothing is printed while it is drawn, and the pictures are for looking at.

./dev test --only ui -k panel_pictures
"""

import contextlib
import pathlib
import tempfile
from unittest import mock

import addon_utils
import bpy
from harness import view
from support import baking, handles, installed, libraries, meshes, steps


def _shown_tube(ui):
    """A tube in the opened tab."""
    tube = meshes.tube(handles.RINGS, handles.SEGMENTS)
    ui.frame_all()
    yield from ui.open_tab("Mean-Value")
    return tube


def _press(operator):
    assert operator('EXEC_DEFAULT', True) == {'FINISHED'}


def from_nothing_to_applied(ui):
    tube = yield from _shown_tube(ui)
    yield from ui.screenshot("panel_01_nothing_yet")
    bpy.ops.object.mode_set(mode='EDIT')
    yield from ui.invoke("meanvalue.grab", choose_tool=True)
    assert tube.mode == 'OBJECT'
    assert bpy.context.workspace.tools.from_space_view3d_mode('OBJECT').idname == "meanvalue.grab"
    yield from ui.screenshot("panel_02_grab_is_lit")
    steps.list_anchors(tube, Bottom=handles.BOTTOM)
    steps.add_handle(tube, "Top", handles.TOP).location.x += 3.0
    meshes.activate(tube)
    yield from ui.wait_until(lambda: tube.data.shape_keys is not None, "the tube follows")
    _press(bpy.ops.meanvalue.keep_pose)
    yield from ui.screenshot("panel_03_with_handles")
    tube.meanvalue.handles["Top"].control = None
    yield from ui.screenshot("panel_04_without_a_control")
    _press(bpy.ops.meanvalue.bind)
    yield from ui.screenshot("panel_05_updated")


def a_bake_plays(ui):
    tube, _control = baking.animated_tube()
    ui.frame_all()
    yield from ui.open_tab("Mean-Value")
    tube.meanvalue.bake.target = 'SHAPE_KEYS'
    _press(bpy.ops.meanvalue.bake)
    yield from ui.screenshot("panel_06_a_bake_plays")


def linked(ui):
    tube = yield from _shown_tube(ui)
    tube.data = libraries.linked(pathlib.Path(tempfile.mkdtemp()), tube.data, "meshes")
    yield from ui.screenshot("panel_07_mesh_is_linked")


def edited_after_bind(ui):
    tube = yield from _shown_tube(ui)
    steps.list_anchors(tube, Bottom=handles.BOTTOM, Top=handles.TOP)
    _press(bpy.ops.meanvalue.bind)
    steps.edit_mesh(tube, lambda bm: bm.verts.new((0.0, 0.0, -3.0)))
    yield from ui.screenshot("panel_08_stale_vertices")


def not_available(ui):
    yield from _shown_tube(ui)
    bpy.ops.object.mode_set(mode='EDIT')
    yield from ui.screenshot("panel_09_edit_mode")
    bpy.ops.object.mode_set(mode='OBJECT')
    with _no_solver():
        yield from ui.screenshot("panel_10_solver_missing")
    bpy.context.view_layer.objects.active = None
    yield from ui.screenshot("panel_11_no_object")


def preferences(ui):
    """In place of the 3D View."""
    view.area().type = 'PREFERENCES'
    bpy.context.preferences.active_section = 'ADDONS'
    bpy.context.window_manager.addon_search = "Mean-Value"
    bpy.context.preferences.view.show_addons_enabled_only = True
    for module in addon_utils.modules():
        if module.__name__ == installed.PACKAGE:
            addon_utils.module_bl_info(module)["show_expanded"] = True
    yield from ui.screenshot("panel_12_preferences")
    with _no_solver():
        yield from ui.screenshot("panel_13_preferences_solver_missing")


@contextlib.contextmanager
def _no_solver():
    loader = installed.part("solver.native_loader")
    with mock.patch.object(loader, "MODULE_NAMES", ("nowhere.meanvalue",)):
        loader.forget()
        yield
    loader.forget()
