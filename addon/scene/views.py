# SPDX-License-Identifier: GPL-3.0-or-later
"""What 3D Views and the console show: has Blender draw when it has no reason of its own to."""

import contextlib
import sys
import textwrap

import bpy

from . import pose_objects

#: Told apart without looking alike to most eyes (Okabe and Ito 2008).
COLORS = (
    (0.90, 0.62, 0.00),
    (0.34, 0.71, 0.91),
    (0.00, 0.62, 0.45),
    (0.94, 0.89, 0.26),
    (0.84, 0.37, 0.00),
    (0.80, 0.47, 0.65),
)


def draw_again(region_type=None, area_type='VIEW_3D'):
    """All 3D Views, or their regions of one type; or editors of another type."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == area_type:
                for region in area.regions:
                    if region_type in {None, region.type}:
                        region.tag_redraw()


def show_in_local_views(obj, beside):
    """A new object is to be seen where `beside` is looked at alone (Local View)."""
    beside = pose_objects.shown(beside)
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            space = area.spaces.active
            if area.type == 'VIEW_3D' and space.local_view is not None and beside.local_view_get(space):
                obj.local_view_set(space, True)


def is_visible(obj, space):
    """Whether a 3D View shows the object: not hidden, in the view's collections, and in its Local View if there is one,
    of which copies alone know."""
    depsgraph = bpy.context.view_layer.depsgraph
    obj = pose_objects.shown(obj)
    evaluated = obj if depsgraph is None else obj.evaluated_get(depsgraph)
    return obj.visible_get(viewport=space) and evaluated.visible_in_viewport_get(space)


#: What has Blender evaluate an object that is not.
ENABLE = "Enable it (the monitor in the Outliner, the tick of its collection) and hide it by the eye instead"


def is_evaluated(obj):
    """Whether Blender evaluates an object in this view layer on its own account. Hidden by the eye it does."""
    obj = pose_objects.shown(obj)
    if obj.visible_get():
        return True
    return not obj.hide_viewport and _is_reached(bpy.context.view_layer.layer_collection, obj, "hide_viewport")


def _is_reached(layer_collection, obj, switch):
    """Whether a collection has the object for which, and for those above it, the switch (hide_...) is off."""
    collection = layer_collection.collection
    if getattr(collection, switch):
        return False
    found = None if layer_collection.exclude else collection.objects.get(obj.name)
    if found == obj or (found is not None and obj in collection.objects[:]):  # a linked one may have its name
        return True
    return any(_is_reached(child, obj, switch) for child in layer_collection.children)


def is_pressable(obj, context):
    """Whether a press can be meant for what a 3D View shows of the object: not wire, nor what cannot be selected."""
    obj = pose_objects.shown(obj)
    is_solid = obj.display_type not in {'WIRE', 'BOUNDS'} and not obj.hide_select
    is_solid = is_solid and _is_reached(context.view_layer.layer_collection, obj, "hide_select")
    return is_solid and is_visible(obj, context.space_data)


@contextlib.contextmanager
def where_shown(obj):
    """Timers and handlers act in the first window's scene. Inside, the context is that of a window that has `obj`."""
    windows, obj = bpy.context.window_manager.windows, pose_objects.shown(obj)
    if len(windows) < 2 or obj.visible_get():  # looking names up goes through all objects
        yield
        return
    shown = [each for each in windows if obj.name in each.view_layer.objects]
    with bpy.context.temp_override(window=shown[0]) if shown else contextlib.nullcontext():
        yield


def say(text):
    """To the console, in the letters that it has: Windows' own has few, and printing others is an error."""
    encoding = sys.stdout.encoding or "utf-8"
    print("Mean-Value:", text.encode(encoding, "backslashreplace").decode(encoding))


_window = None  # pointer of the one in which an operator of ours ran last


def note_window():
    """An operator runs: the artist is at work in its window."""
    global _window
    _window = bpy.context.window.as_pointer() if bpy.context.window is not None else _window


def pop_up(title, text):
    """A popup with `text` under the mouse, from where there is no context, as in timers."""
    manager = bpy.context.window_manager
    if not manager.windows:
        return
    window = next((each for each in manager.windows if each.as_pointer() == _window), manager.windows[0])
    lines = textwrap.wrap(text, 80)

    def draw(popup, _context):
        for line in lines:
            popup.layout.label(text=line)

    with bpy.context.temp_override(window=window):
        manager.popup_menu(draw, title=title, icon='ERROR')
