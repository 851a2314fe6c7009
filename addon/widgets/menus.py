# SPDX-License-Identifier: GPL-3.0-or-later
"""Menus of operators. What is in a menu is found by Menu Search (F3), too."""

import bpy

#: Names of the rooms' menus, in the order of the rooms: shown at the end of the add-on's menu in Blender's Object menu.
of_rooms = []


class OperatorMenu:
    """Mix-in: subclasses have `operators`, classes or their names; None draws a line."""

    operators = ()

    def draw(self, _context):
        draw_operators(self.layout, self.operators)


def of_room(name, label, about, operators):
    """The class of a room's menu. about: what the room is for, as the tooltip says it."""
    members = {"__doc__": about, "bl_idname": name, "bl_label": label, "operators": operators}
    return type(name, (OperatorMenu, bpy.types.Menu), members)


def draw_operators(layout, operators):
    layout.operator_context = 'INVOKE_DEFAULT'
    for operator in operators:
        if operator is None:
            layout.separator()
        else:
            layout.operator(getattr(operator, "bl_idname", operator))
