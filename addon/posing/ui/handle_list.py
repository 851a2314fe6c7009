# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of handles and pins."""

import bpy

from ...scene import subject
from ..bridge import controls

FOLLOWS_ICONS = {'CONTROL': 'EMPTY_AXIS', 'REST': 'PINNED'}


class MEANVALUE_UL_handles(bpy.types.UIList):
    """One line for each handle or pin: on or off, color, name, and a button to select it"""

    def draw_item(self, context, layout, _data, item, _icon, _active_data, _active_property, index):
        obj = subject.of(context)
        missing = item.name not in obj.vertex_groups
        row = layout.row(align=True)
        row.prop(item, "is_enabled", text="")
        color = row.row(align=True)
        color.ui_units_x = 0.6
        color.prop(item, "color", text="")
        broken = missing or (item.follows == 'CONTROL' and controls.problem(obj, item) is not None)
        name = row.row()
        name.alert = broken
        name.active = item.is_enabled
        icon = 'ERROR' if broken else FOLLOWS_ICONS[item.follows]
        name.label(text=item.name, icon=icon, translate=False)
        row.operator("meanvalue.select_handle", text="", icon='RESTRICT_SELECT_OFF').index = index

    def filter_items(self, _context, data, collection):
        """Without the handles whose control was deleted."""
        handles = getattr(data, collection)
        if self.filter_name:
            shown = bpy.types.UI_UL_list.filter_items_by_name(self.filter_name, self.bitflag_filter_item, handles)
        else:
            shown = [self.bitflag_filter_item] * len(handles)
        return [0 if controls.is_deleted(handle) else flag for handle, flag in zip(handles, shown, strict=True)], []
