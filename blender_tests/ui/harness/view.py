# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's window, the 3D View in it, and where things are on it. Looked up on every call: files are loaded."""

import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d


def window():
    return bpy.context.window_manager.windows[0]


def area():
    return next(area for area in window().screen.areas if area.type == 'VIEW_3D')


def region(kind='WINDOW'):
    return next(region for region in area().regions if region.type == kind)


def override():
    """Context manager: operators find the context that they have when the mouse is over the 3D View."""
    return bpy.context.temp_override(window=window(), screen=window().screen, area=area(), region=region())


def project(location):
    """(x, y) in the window of a location in the world.

    @throws AssertionError if it is not in the view.
    """
    main = region()
    point = location_3d_to_region_2d(main, area().spaces.active.region_3d, location)
    assert point and 0 <= point.x < main.width and 0 <= point.y < main.height, f"{location} is not in the view"
    return main.x + round(point.x), main.y + round(point.y)


def centre():
    """Of the part of the 3D View that no sidebar or toolbar covers."""
    main = region()
    left, right = main.x, main.x + main.width
    if area().spaces.active.show_region_ui:
        right = min(right, region('UI').x)
    return (left + right) // 2, main.y + main.height // 2


def frame_all():
    with override():
        bpy.ops.view3d.view_all()


def redraw():
    for each in window().screen.areas:
        each.tag_redraw()
