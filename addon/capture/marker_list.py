# SPDX-License-Identifier: GPL-3.0-or-later
"""The lists of Motion Capture: markers with their distance from the mesh, and problems of the take."""

import bpy


class MEANVALUE_UL_marker_pairs(bpy.types.UIList):
    """One line for each marker: whether it is used, its name, how far it is from its point; the worst first. A click
    selects its control or Empty"""

    use_filter_sort_reverse = False

    def draw_item(self, context, layout, _data, item, _icon, _active_data, _active_property):
        row = layout.row(align=True)
        row.prop(item, "is_used", text="")
        row = row.split(factor=0.6, align=True)
        name = row.row(align=True)
        name.active = item.is_used and (item.control is not None or item.is_picked)
        name.alignment = 'LEFT'
        name.label(text=item.name, translate=False, icon='EYEDROPPER' if item.is_picked else 'NONE')
        row.label(text=_length(context, item.distance) if item.distance >= 0.0 else "")

    def filter_items(self, _context, data, property_name):
        pairs = getattr(data, property_name)
        flags = bpy.types.UI_UL_list.filter_items_by_name(self.filter_name, self.bitflag_filter_item, pairs)
        if self.use_filter_sort_alpha:
            return flags, bpy.types.UI_UL_list.sort_items_by_name(pairs)
        worst = sorted(range(len(pairs)), key=lambda number: -pairs[number].distance)
        order = [0] * len(pairs)
        for place, number in enumerate(worst):
            order[number] = place
        return flags, order


class MEANVALUE_UL_marker_problems(bpy.types.UIList):
    """One line for each problem, with its frame; a click goes there"""

    def draw_item(self, _context, layout, _data, item, _icon, _active_data, _active_property):
        split = layout.split(factor=0.2)
        split.label(text=f"{item.frame:.0f}")
        split.label(text=item.text)


def _length(context, metres):
    units = context.scene.unit_settings
    return bpy.utils.units.to_string(
        units.system, 'LENGTH', metres * units.scale_length, precision=2, compatible_unit=False
    )


CLASSES = (MEANVALUE_UL_marker_pairs, MEANVALUE_UL_marker_problems)
