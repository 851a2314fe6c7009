# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of anchor groups."""

import bpy

from ..bridge import object_status


class MEANVALUE_UL_anchor_groups(bpy.types.UIList):
    """One line for each anchor group: its name and how many vertices it has"""

    def draw_item(self, context, layout, _data, item, _icon, _active_data, _active_property, _index):
        missing = item.name not in context.object.vertex_groups
        status = object_status.last_known(context.object)
        count = status.member_counts.get(item.name) if status else None
        row = layout.row()
        row.alert = missing
        row.label(text=item.name, icon='ERROR' if missing else 'GROUP_VERTEX')
        label = row.row()
        label.alignment = 'RIGHT'
        label.label(text="missing" if missing else "" if count is None else f"{count:,}")
