# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws anchors and region into the 3D View. What is drawn comes from posing/bridge/overlay_data.py."""

from dataclasses import dataclass

import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

from ... import compat
from ..bridge import overlay_data
from ..operators import hover

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

#: Where the region is tinted. Weight Paint shows it itself.
TINTED_MODES = {'OBJECT'}

_batches = None  # of the look that was drawn last
_hover = None  # (the Hover that was drawn last, its batch)


@dataclass(eq=False)
class _Batches:
    """On the graphics card; None for what is empty."""

    look: overlay_data.Look
    points: object
    tint: object
    tint_triangles: object


def paint(context, obj):
    global _batches
    look = overlay_data.look(obj)
    if _batches is None or _batches.look is not look:
        _batches = _make_batches(look, _batches)
    wrote_depth = gpu.state.depth_mask_get()
    gpu.state.blend_set('ALPHA')
    gpu.state.depth_test_set('NONE' if obj.show_in_front else 'LESS_EQUAL')
    gpu.state.depth_mask_set(False)
    try:
        with gpu.matrix.push_pop():
            gpu.matrix.multiply_matrix(obj.matrix_world)
            if _batches.tint is not None and obj.mode in TINTED_MODES:
                _draw_closer(context, TINT_CLOSER, _batches.tint, compat.surface_shader())
            _paint_hover(context, obj)
            if _batches.points is not None:
                gpu.state.point_size_set(POINT_PIXELS * context.preferences.system.ui_scale)
                _draw_closer(context, POINTS_CLOSER, _batches.points, compat.points_shader())
    finally:
        gpu.state.point_size_set(1.0)
        gpu.state.depth_mask_set(wrote_depth)
        gpu.state.depth_test_set('NONE')
        gpu.state.blend_set('NONE')


def _paint_hover(context, obj):
    global _hover
    found = hover.of(context, obj)
    if found is None:
        _hover = None
    elif len(found.corners):
        if _hover is None or _hover[0] is not found:
            triangles = gpu.types.GPUIndexBuf(type='TRIS', seq=found.corners)
            _hover = found, gpu.types.GPUBatch(type='TRIS', buf=_vertex_buffer(found, HOVER), elem=triangles)
        _draw_closer(context, TINT_CLOSER, _hover[1], compat.surface_shader())


def _draw_closer(context, share, batch, shader):
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


def _make_batches(look, former):
    """`former`: the batches before; its triangles are used again if they are the same."""
    points = tint = triangles = None
    if len(look.points):
        points = batch_for_shader(compat.points_shader(), 'POINTS', {"pos": look.points, "color": look.colors})
    if len(look.corners):
        is_same = former is not None and former.look.corners is look.corners
        triangles = former.tint_triangles if is_same else gpu.types.GPUIndexBuf(type='TRIS', seq=look.corners)
        tint = gpu.types.GPUBatch(type='TRIS', buf=_vertex_buffer(look, TINT), elem=triangles)
    return _Batches(look, points, tint, triangles)


def _vertex_buffer(look, color):
    """Places and colors of the region's vertices: the less a vertex moves, the fainter it is.

    The format is spelt out, since that which a shader gives (format_calc) is empty in 5.2.
    """
    layout = gpu.types.GPUVertFormat()
    layout.attr_add(id="pos", comp_type='F32', len=3, fetch_mode='FLOAT')
    layout.attr_add(id="color", comp_type='F32', len=4, fetch_mode='FLOAT')
    vertices = gpu.types.GPUVertBuf(layout, len(look.tint))
    vertices.attr_fill("pos", look.tint)
    colors = np.tile(np.array(color, np.float32), (len(look.tint), 1))
    colors[:, 3] *= look.freedom
    vertices.attr_fill("color", colors)
    return vertices


def forget():
    global _batches, _hover
    _batches = _hover = None
