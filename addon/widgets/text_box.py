# SPDX-License-Identifier: GPL-3.0-or-later
"""Texts of several lines, which Blender's labels do not break by themselves."""

import textwrap

#: Width of an average letter and of a label's margins, in pixels at interface scale 1.
LETTER_WIDTH = 7.0
MARGIN_WIDTH = 60.0
SHORTEST_LINE = 16


def draw_wrapped(layout, context, text, icon='NONE'):
    """Labels for `text`, broken to the width of the region; the icon stands at the first line."""
    scale = context.preferences.system.ui_scale
    letters = int((context.region.width / scale - MARGIN_WIDTH) / LETTER_WIDTH)
    column = layout.column(align=True)
    column.scale_y = 0.8
    for line in textwrap.wrap(text, max(letters, SHORTEST_LINE)):
        column.label(text=line, icon=icon)
        icon = 'NONE' if icon == 'NONE' else 'BLANK1'
