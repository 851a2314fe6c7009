# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panels of the sidebar share, and menus. What is in a menu is found by Menu Search (F3), too."""

import textwrap

import bpy

from .. import ids
from ..rooms import classes_in
from ..scene import subject

#: Width of an average letter and of a label's margins, in pixels at interface scale 1.
LETTER_WIDTH = 7.0
MARGIN_WIDTH = 60.0
SHORTEST_LINE = 16


def column_of_settings(layout):
    """A column with the names of settings beside them, as in Blender's own panels, and no buttons for keyframes."""
    column = layout.column()
    column.use_property_split = True
    column.use_property_decorate = False
    return column


def draw_main_button(layout, operator, icon, more=""):
    """A larger one, for what the settings above it are for, with `more` behind its name."""
    button = layout.column()
    button.scale_y = 1.4
    button.operator(operator.bl_idname, text=operator.bl_label + more, icon=icon)


def draw_range(layout, settings):
    """The frames to bake: see OPTIONS of baking/properties.py."""
    column = layout.column(align=True)
    column.prop(settings, "frame_range")
    if settings.frame_range == 'OWN':
        column.prop(settings, "frame_start")
        column.prop(settings, "frame_end")


def draw_wrapped(layout, context, text, icon='NONE'):
    """Labels for `text`, broken to the width of the region; the icon stands at the first line."""
    scale = context.preferences.system.ui_scale
    letters = int((context.region.width / scale - MARGIN_WIDTH) / LETTER_WIDTH)
    column = layout.column(align=True)
    column.scale_y = 0.8
    for line in textwrap.wrap(text, max(letters, SHORTEST_LINE)):
        column.label(text=line, icon=icon)
        icon = 'NONE' if icon == 'NONE' else 'BLANK1'


class SidebarPanel:
    """Mix-in of all panels here. Parts show only where there is a mesh to work on."""

    bl_space_type = 'VIEW_3D'
    bl_region_type = 'UI'
    bl_category = ids.SIDEBAR_TAB


class PanelPart(SidebarPanel):
    bl_parent_id = "MEANVALUE_PT_panel"
    bl_options = {'DEFAULT_CLOSED'}

    @classmethod
    def poll(cls, context):
        return subject.object_problem(subject.of(context)) is None


def of_room(name, label, about, *modules):
    """The class of a room's menu, with the operators of these modules. about: what it is for, as a tooltip."""
    operators = classes_in(modules, "MEANVALUE_OT_")

    def draw(menu, _context):
        draw_operators(menu.layout, operators)

    return type(name, (bpy.types.Menu,), {"__doc__": about, "bl_label": label, "draw": draw})


def draw_operators(layout, operators):
    """operators: classes or their names; None draws a line."""
    layout.operator_context = 'INVOKE_DEFAULT'
    for operator in operators:
        if operator is None:
            layout.separator()
        else:
            layout.operator(getattr(operator, "bl_idname", operator))
