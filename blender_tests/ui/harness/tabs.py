# SPDX-License-Identifier: GPL-3.0-or-later
"""Opens a tab of the sidebar. Blender before 4.2 tells neither which is open nor where they are."""

import bpy
from support import installed

from . import view

TAB_FROM_RIGHT = 10
# Down from the top: where the first tab after Blender's own three is, then everywhere.
TAB_HEIGHTS = (165, *range(30, 600, 30))


def open_tab(category, click):
    """Clicks down the row of tabs until a panel of `category` is drawn. `click(x, y)` is a generator.

    @throws AssertionError if there is no such tab.
    """
    assert category in _categories(), f"there is no tab {category}; there are {_categories()}"
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
        assert probe.drawn, f"the tab {category} is shown nowhere"
    finally:
        bpy.utils.unregister_class(probe)
    view.redraw()
    yield


def open_part(ui, room, name=""):
    """As ui.open_tab("Mean-Value"), with the parts of the panel open that a room has, or just `name`."""
    modules = [installed.part(f"{name}.panel") for name in ("posing.ui", "capture", "wrapping", "baking", "sliders")]
    panels = installed.part("rooms").classes_in(modules, "MEANVALUE_PT_")
    for panel in [panel for panel in panels if hasattr(panel, "bl_parent_id")]:
        bpy.utils.unregister_class(panel)
        is_open = panel.__module__.endswith(f"{room}.panel") and name in panel.__name__
        panel.bl_options = set() if is_open else {'DEFAULT_CLOSED'}
        bpy.utils.register_class(panel)
    yield from ui.open_tab("Mean-Value")


def scroll_down(ui):
    """The sidebar down to its end."""
    sidebar = view.region('UI')
    yield from ui.move_mouse(sidebar.x + 4, sidebar.y + 300)  # beside the lists, which scroll by themselves
    for _ in range(40):
        yield from ui.key('WHEELDOWNMOUSE')


def _categories():
    """Of all panels but the probe, which would make a tab of any name."""
    panels = [panel for panel in bpy.types.Panel.__subclasses__() if panel.__name__ != "MEANVALUE_PT_probe"]
    return sorted({panel.bl_category for panel in panels if hasattr(panel, "bl_category")})


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
