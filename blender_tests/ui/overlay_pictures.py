# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the overlay, the presets, the menus and the shortcuts, for looking at, and what the overlay costs.

Run it like panel_pictures.py. Writes build/ui/overlay_*.png, and prints how long the callback takes at 50,000 vertices.
"""

import os
import pathlib
import sys
import time
import traceback

import bpy
import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
PICTURES = HERE.parents[1] / "build" / "ui"
PACKAGE = "meanvalue_deform"
SETTLE_SECONDS = 2.0
BETWEEN_STEPS = 0.7

sys.path.insert(0, str(HERE.parent))
from support import meshes, steps  # noqa: E402


def part(name):
    return sys.modules[f"{PACKAGE}.{name}"]


def view():
    """(window, 3D View, its main region)."""
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == 'VIEW_3D')
    return window, area, next(region for region in area.regions if region.type == 'WINDOW')


def in_view(operator, *arguments, **options):
    window, area, region = view()
    with bpy.context.temp_override(window=window, area=area, region=region):
        operator(*arguments, **options)


def press(key, **modifiers):
    window, area, _region = view()
    x, y = area.x + area.width // 3, area.y + area.height // 2
    window.event_simulate('MOUSEMOVE', 'NOTHING', x=x, y=y)
    for value in ('PRESS', 'RELEASE'):
        window.event_simulate(key, value, x=x, y=y, **modifiers)


def write(letters):
    window, area, _region = view()
    x, y = area.x + area.width // 3, area.y + area.height // 2
    for letter in letters:
        window.event_simulate(letter.upper(), 'PRESS', x=x, y=y, unicode=letter)
        window.event_simulate(letter.upper(), 'RELEASE', x=x, y=y)


def click(x, y):
    window, _area, _region = view()
    window.event_simulate('MOUSEMOVE', 'NOTHING', x=x, y=y)
    for value in ('PRESS', 'RELEASE'):
        window.event_simulate('LEFTMOUSE', value, x=x, y=y)


def sidebar():
    return next(region for region in view()[1].regions if region.type == 'UI')


def open_tab():
    """The tab of the add-on is the last one; it stands below Item, Tool and View at the right edge."""
    if bpy.app.version >= (4, 2, 0):
        sidebar().active_panel_category = "Mean-Value"
        return
    click(sidebar().x + sidebar().width - 12, sidebar().y + sidebar().height - 180)


def scroll_down():
    window, x, y = view()[0], sidebar().x + 80, sidebar().y + 200
    window.event_simulate('MOUSEMOVE', 'NOTHING', x=x, y=y)
    for _ in range(20):
        window.event_simulate('WHEELDOWNMOUSE', 'PRESS', x=x, y=y)


def tube_with_handles():
    tube = meshes.tube(rings=25, segments=24, name="Tube")
    bpy.data.objects.remove(bpy.data.objects["Cube"])
    steps.add_group(tube, "Bottom", range(24))
    steps.add_group(tube, "Top", range(24 * 24, 25 * 24))
    steps.add_group(tube, "Middle", [24 * 12 + 6 * k for k in range(4)])
    bpy.ops.meanvalue.add_pin(group="Bottom")
    bpy.ops.meanvalue.add_handle(group="Middle")
    meshes.activate(tube)
    bpy.ops.meanvalue.add_handle(group="Top")
    meshes.activate(tube)
    bpy.ops.meanvalue.grow_region(mode='DISTANCE', distance=6.0)
    return tube


def shading(kind, **options):
    space = view()[1].spaces.active
    space.shading.type = kind
    for name, value in options.items():
        setattr(space.shading, name, value)


def scene():
    """Yields (name of the picture or None, what to do before it)."""
    yield None, lambda: press('ESC')
    view()[1].spaces.active.show_region_ui = True
    tube = tube_with_handles()
    yield "region", lambda: in_view(bpy.ops.view3d.view_all)
    control = tube.meanvalue.anchor_groups["Top"].control
    control.location.x += 3.0
    control.location.z -= 2.0
    yield "posed", lambda: meshes.activate(control)
    yield "orthographic", lambda: in_view(bpy.ops.view3d.view_persportho)
    yield "xray", lambda: shading('SOLID', show_xray=True)
    yield "wireframe", lambda: shading('WIREFRAME')
    shading('SOLID', show_xray=False)
    yield "in_front", lambda: setattr(tube, "show_in_front", True)
    tube.show_in_front = False
    tube.modifiers.new("Subdivision", 'SUBSURF')
    yield "subdivided", lambda: None
    tube.modifiers.clear()
    meshes.activate(tube)
    yield "weight_paint", lambda: bpy.ops.meanvalue.paint_region()
    bpy.ops.meanvalue.finish_region()
    yield "overlays_off", lambda: setattr(view()[1].spaces.active.overlay, "show_overlays", False)
    view()[1].spaces.active.overlay.show_overlays = True
    yield "object_hidden", lambda: tube.hide_set(True)
    tube.hide_set(False)
    meshes.activate(tube)
    tube.meanvalue.anchor_groups["Middle"].is_enabled = False
    yield "handle_disabled", lambda: None
    yield "search", lambda: press('F3')
    write("growfrom")
    yield "search_found", lambda: None
    press('ESC')
    yield None, lambda: press('ESC')
    yield "menu", lambda: in_view(bpy.ops.wm.call_menu, 'INVOKE_DEFAULT', name="MEANVALUE_MT_object")
    yield None, lambda: press('ESC')
    yield "presets", lambda: in_view(bpy.ops.wm.call_panel, 'INVOKE_DEFAULT', name="MEANVALUE_PT_presets")
    yield None, lambda: press('ESC')
    yield None, open_tab
    yield "panel", scroll_down
    before = tube.meanvalue.live
    press('L', alt=True)
    yield "live_toggled", lambda: None
    print("Alt L toggled Live:", tube.meanvalue.live != before)
    tube.meanvalue.live = False
    big = big_grid()
    yield "big", lambda: in_view(bpy.ops.view3d.view_all)
    yield from measured(big)
    yield "preferences", show_preferences


def big_grid():
    """50,176 vertices, half of them in the region, 200 anchors."""
    obj = meshes.grid(columns=224, rows=224, name="Big")
    steps.list_anchors(obj, Handle=range(0, 20000, 100))
    steps.add_group(obj, "Half", range(25000))
    obj.meanvalue.roi_group = "Half"
    obj.shape_key_add(name="Basis")
    obj.shape_key_add(name="Mean-Value").value = 1.0
    return obj


def measured(obj):
    """Steps that time real redraws, each in the processor time of this thread: what is read and made, and all of it.

    All of it has the drawing by the processor in it, where there is no graphics card.
    """
    overlay, data, shape_keys = part("ui.overlay"), part("bridge.overlay_data"), part("bridge.shape_keys")
    key = obj.data.shape_keys.key_blocks["Mean-Value"]
    shape = shape_keys.positions(key)
    heights = iter(range(1, 100))

    def new_shape():
        shape_keys.write_positions(obj.data, key, shape + np.float32(0.01 * next(heights)))
        bpy.context.view_layer.update()
        data._edited.clear()  # groups are not read again while it goes on

    timed = [(data, "look"), (overlay, "_make_batches"), (overlay, "_draw")]
    originals = [getattr(module, name) for module, name in timed]
    for name, change in {"nothing new": int, "new shape": new_shape, "all read again": data.clear}.items():
        milliseconds = [time_calls(module, function) for module, function in timed]
        for _ in range(8):
            yield None, change
        looks, makes, draws = (np.median(values or [0.0]) for values in milliseconds)
        print(f"overlay, {name}: look {looks:.2f} ms, batches {makes:.2f} ms, in all {draws:.2f} ms")
        for (module, function), original in zip(timed, originals, strict=True):
            setattr(module, function, original)


def time_calls(module, name):
    """From here on, the milliseconds of every call go to the list that is returned."""
    original, milliseconds = getattr(module, name), []

    def timed(*arguments):
        start = time.thread_time()
        result = original(*arguments)
        milliseconds.append(1000 * (time.thread_time() - start))
        return result

    setattr(module, name, timed)
    return milliseconds


def show_preferences():
    """In place of the 3D View, which is not needed any more."""
    import addon_utils

    _window, area, _region = view()
    area.type = 'PREFERENCES'
    bpy.context.preferences.active_section = 'ADDONS'
    bpy.context.window_manager.addon_search = "Mean-Value"
    bpy.context.preferences.view.show_addons_enabled_only = True
    for module in addon_utils.modules():
        if module.__name__ == PACKAGE:
            addon_utils.module_bl_info(module)["show_expanded"] = True


def take(name):
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window, screen=window.screen):
        bpy.ops.screen.screenshot(filepath=str(PICTURES / f"overlay_{name}.png"))


def quit_with(status):
    sys.stdout.flush()
    os._exit(status)


def run():
    PICTURES.mkdir(parents=True, exist_ok=True)
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
            for area in bpy.context.window_manager.windows[0].screen.areas:
                area.tag_redraw()
            if name:
                waiting.append(name)
        except StopIteration:
            quit_with(0)
        except Exception:  # a timer's exception would leave the window open for ever
            traceback.print_exc()
            quit_with(1)
        return SETTLE_SECONDS if waiting else BETWEEN_STEPS

    bpy.app.timers.register(step, first_interval=2.0)


run()
