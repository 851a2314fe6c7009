# SPDX-License-Identifier: GPL-3.0-or-later
"""Opens a tab of the sidebar. Blender before 4.2 tells neither which is open nor where they are."""

import bpy

from . import view

TAB_FROM_RIGHT = 10
# Down from the top: where the first tab after Blender's own three is, then everywhere.
TAB_HEIGHTS = (165, *range(30, 600, 30))


def open_tab(category, click):
    """Clicks down the row of tabs until a panel of `category` is drawn. `click(x, y)` is a generator.

    @throws AssertionError if there is no such tab.
    """
    view.area().spaces.active.show_region_ui = True
    view.redraw()
    yield
    probe = _probe(category)
    bpy.utils.register_class(probe)
    try:
        sidebar = view.region('UI')
        for down in TAB_HEIGHTS:
            yield from click(sidebar.x + sidebar.width - TAB_FROM_RIGHT, sidebar.y + sidebar.height - down)
            sidebar.tag_redraw()
            yield
            if probe.drawn:
                break
        assert probe.drawn, f"there is no tab {category}"
    finally:
        bpy.utils.unregister_class(probe)
    view.redraw()
    yield


def _probe(category):
    class MEANVALUE_PT_probe(bpy.types.Panel):  # noqa: N801  Blender's rule for names
        bl_label = "Probe"
        bl_space_type = 'VIEW_3D'
        bl_region_type = 'UI'
        bl_category = category
        drawn = False

        def draw(self, _context):
            type(self).drawn = True

    return MEANVALUE_PT_probe
