# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws anchors and region into the 3D View. What is drawn comes from posing/bridge/overlay_data.py."""

import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

from ... import compat
from ...widgets.overlay import drawing
from ..bridge import overlay_data
from ..operators import tool_choice

#: Size of an anchor at interface scale 1: small, since the surface has to show between them.
POINT_PIXELS = 4.0

#: Color and opacity of what moves freely.
TINT = (0.25, 0.6, 1.0, 0.2)

#: The same of what would move freely after a press.
HOVER = (0.35, 0.7, 1.0, 0.45)

#: How much closer to the eye things are drawn than they are, so that they are not half hidden by the surface that they
#: lie on; a share of their distance.
TINT_CLOSER = 0.0025
POINTS_CLOSER = 0.005

_drawn = {}  # function that makes a batch, and a color: (what it made the last one of, that batch, its shader)


def paint(context, obj):
    look, found = overlay_data.look(obj), tool_choice.would_follow(context, obj)
    with drawing(context, obj, 'NONE' if obj.show_in_front else 'LESS_EQUAL', POINT_PIXELS):
        if len(look.corners) and obj.mode == 'OBJECT':  # Weight Paint shows the region itself
            _draw_closer(context, TINT_CLOSER, look, _faces, TINT)
        if found is not None and len(found.corners):
            _draw_closer(context, TINT_CLOSER, found, _faces, HOVER)
        if len(look.points):
            _draw_closer(context, POINTS_CLOSER, look, _points)


def _draw_closer(context, share, shown, make, *color):
    """Draws the (batch, shader) that make(shown, *color) gives, which are kept for as long as the same is shown."""
    key = make, *color
    if key not in _drawn or _drawn[key][0] is not shown:
        _drawn[key] = shown, *make(shown, *color)
    _, batch, shader = _drawn[key]
    with gpu.matrix.push_pop_projection():
        projection = gpu.matrix.get_projection_matrix()
        gpu.matrix.load_projection_matrix(closer(projection, context.region_data.view_distance, share))
        batch.draw(shader)


def closer(projection, view_distance, share):
    """The 4 x 4 projection with everything nearer to the eye by `share`, and at the same place in the picture."""
    moved = projection.copy()
    is_orthographic = projection[3][3] > 0.5
    if is_orthographic:
        moved[2][3] += projection[2][2] * share * view_distance
    else:
        moved[2][3] *= 1.0 + share
    return moved


def _points(look):
    shader = compat.shader("POINT_FLAT_COLOR")
    return batch_for_shader(shader, 'POINTS', {"pos": look.points, "color": look.colors}), shader


def _faces(shown, color):
    """The less a vertex moves, the fainter it is."""
    colors = np.tile(np.array(color, np.float32), (len(shown.tint), 1))
    colors[:, 3] *= shown.freedom
    shader = compat.shader("SMOOTH_COLOR")
    return batch_for_shader(shader, 'TRIS', {"pos": shown.tint, "color": colors}, indices=shown.corners), shader


def forget():
    _drawn.clear()
