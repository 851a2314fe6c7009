# SPDX-License-Identifier: GPL-3.0-or-later
"""Menus of operators. What is in a menu is found by Menu Search (F3), too."""

import bpy

from ..rooms import classes_in


def of_room(name, label, about, *modules):
    """The class of a room's menu, with the operators of these modules. about: what it is for, as the tooltip says it.
    """

    def draw(menu, _context):
        draw_operators(menu.layout, classes_in(modules, "MEANVALUE_OT_"))

    return type(name, (bpy.types.Menu,), {"__doc__": about, "bl_label": label, "draw": draw})


def draw_operators(layout, operators):
    """operators: classes or their names; None draws a line."""
    layout.operator_context = 'INVOKE_DEFAULT'
    for operator in operators:
        if operator is None:
            layout.separator()
        else:
            layout.operator(getattr(operator, "bl_idname", operator))
