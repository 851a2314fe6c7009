# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the panel in each of its states, for looking at.

    MEANVALUE_ADDON_ZIP=... BLENDER_USER_SCRIPTS=... xvfb-run -a -s "-screen 0 1280x800x24 +extension GLX" \\
        blender --factory-startup -noaudio --enable-event-simulate --window-geometry 0 0 1280 800 \\
        --python-exit-code 1 --python blender_tests/ui/panel_pictures.py

Writes build/ui/*.png. The buttons are pressed by mouse where that is what is to be seen.
"""

import os
import pathlib
import sys
import traceback

import bpy

HERE = pathlib.Path(__file__).resolve().parent
PICTURES = HERE.parents[1] / "build" / "ui"
PACKAGE = "meanvalue_deform"
SETTLE_SECONDS = 2.0

sys.path.insert(0, str(HERE.parent))
from support import meshes, steps  # noqa: E402


def view():
    """(window, area, sidebar) of the 3D View."""
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == 'VIEW_3D')
    sidebar = next(region for region in area.regions if region.type == 'UI')
    return window, area, sidebar


def take(name):
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window, screen=window.screen):
        bpy.ops.screen.screenshot(filepath=str(PICTURES / f"{name}.png"))
    print("picture", name)


def click(x, y):
    window, _area, _sidebar = view()
    window.event_simulate('MOUSEMOVE', 'NOTHING', x=x, y=y)
    window.event_simulate('LEFTMOUSE', 'PRESS', x=x, y=y)
    window.event_simulate('LEFTMOUSE', 'RELEASE', x=x, y=y)


def press_escape():
    """Closes the splash screen."""
    window, _area, _sidebar = view()
    window.event_simulate('ESC', 'PRESS', x=300, y=300)
    window.event_simulate('ESC', 'RELEASE', x=300, y=300)


def open_tab():
    """The tab of the add-on is the last one; it stands below Item, Tool and View at the right edge."""
    _window, _area, sidebar = view()
    if hasattr(sidebar, "active_panel_category") and bpy.app.version >= (4, 2, 0):
        sidebar.active_panel_category = "Mean-Value"
    else:
        click(sidebar.x + sidebar.width - 12, sidebar.y + sidebar.height - 180)


def scene():
    """Yields (name of the picture or None, what to do before it). References are looked up again: undo is at work."""
    obj = bpy.data.objects["Cube"]
    yield None, press_escape
    yield None, lambda: setattr(view()[1].spaces.active, "show_region_ui", True)
    yield None, open_tab
    yield "00_new_cube", lambda: meshes.activate(obj)
    tube = meshes.tube(rings=25, segments=24, name="Tube")
    bpy.data.objects.remove(obj)
    yield "01_no_anchors", frame_all
    steps.list_anchors(tube, Bottom=range(24), Top=range(24 * 24, 25 * 24))
    yield "02_not_bound", lambda: None
    bpy.ops.meanvalue.bind('EXEC_DEFAULT', True)
    yield "03_bound_without_pose", lambda: None
    bpy.ops.meanvalue.add_pose_key('EXEC_DEFAULT', True)
    steps.move(tube, range(24 * 24, 25 * 24), (3.0, 0.0, -2.0))
    yield "04_posed", lambda: None
    bpy.ops.meanvalue.solve('EXEC_DEFAULT', True)
    yield "05_solved", lambda: None
    tube.vertex_groups["Bottom"].add([24 * 2], 1.0, 'REPLACE')
    yield "06_stale_anchors", lambda: None
    steps.edit_mesh(tube, lambda bm: bm.verts.new((0.0, 0.0, -3.0)))
    yield "07_stale_vertices", lambda: None
    tube.vertex_groups["Top"].name = "Hand of the long-named creature"
    yield "08_group_missing", lambda: None
    bpy.ops.object.mode_set(mode='EDIT')
    yield "09_edit_mode", lambda: None
    bpy.ops.object.mode_set(mode='OBJECT')
    loader = sys.modules[PACKAGE + ".native_loader"]
    names = loader.MODULE_NAMES
    loader.MODULE_NAMES = ("nowhere.meanvalue",)
    loader.forget()
    yield "10_solver_missing", lambda: None
    bpy.context.view_layer.objects.active = None
    yield "11_no_object", lambda: None
    yield "12_preferences_solver_missing", show_preferences
    loader.MODULE_NAMES = names
    loader.forget()
    yield "13_preferences", lambda: None


def show_preferences():
    """In place of the 3D View, which is not needed any more."""
    import addon_utils

    _window, area, _sidebar = view()
    area.type = 'PREFERENCES'
    bpy.context.preferences.active_section = 'ADDONS'
    bpy.context.window_manager.addon_search = "Mean-Value"
    bpy.context.preferences.view.show_addons_enabled_only = True
    for module in addon_utils.modules():
        if module.__name__ == PACKAGE:
            addon_utils.module_bl_info(module)["show_expanded"] = True


def frame_all():
    window, area, _sidebar = view()
    main = next(region for region in area.regions if region.type == 'WINDOW')
    with bpy.context.temp_override(window=window, area=area, region=main):
        bpy.ops.view3d.view_all()


def draw_all_again():
    for area in bpy.context.window_manager.windows[0].screen.areas:
        area.tag_redraw()


def quit_with(status):
    sys.stdout.flush()
    os._exit(status)


def run():
    PICTURES.mkdir(parents=True, exist_ok=True)
    for old in PICTURES.glob("*.png"):
        old.unlink()
    bpy.ops.preferences.addon_install(filepath=os.environ["MEANVALUE_ADDON_ZIP"], overwrite=True)
    bpy.ops.preferences.addon_enable(module=PACKAGE)
    states = scene()
    waiting = []

    def step():
        try:
            if waiting:
                take(waiting.pop())
            name, action = next(states)
            action()
            draw_all_again()
            if name:
                waiting.append(name)
        except StopIteration:
            quit_with(0)
        except Exception:  # a timer's exception would leave the window open for ever
            traceback.print_exc()
            quit_with(1)
        return SETTLE_SECONDS

    bpy.app.timers.register(step, first_interval=2.0)


run()
