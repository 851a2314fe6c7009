# SPDX-License-Identifier: GPL-3.0-or-later
"""Menus of operators. What is in a menu is found by Menu Search (F3), too."""

#: Names of the rooms' menus, in the order of the rooms: shown at the end of the add-on's menu in Blender's Object menu.
of_rooms = []


class OperatorMenu:
    """Mix-in: subclasses have `operators`, classes or their names; None draws a line."""

    operators = ()

    def draw(self, _context):
        draw_operators(self.layout, self.operators)


def draw_operators(layout, operators):
    layout.operator_context = 'INVOKE_DEFAULT'
    for operator in operators:
        if operator is None:
            layout.separator()
        else:
            layout.operator(getattr(operator, "bl_idname", operator))
