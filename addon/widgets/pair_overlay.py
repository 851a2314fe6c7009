# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the lines from markers to their points on the mesh, and of picked pairs of Wrap.

What is drawn comes from capture/bridge/pair_lines.py and wrapping/bridge/wrap_lines.py.
"""

import traceback

import bpy
import gpu
from gpu_extras.batch import batch_for_shader

from .. import compat
from ..capture.bridge import pair_lines
from ..posing.ui import overlay
from ..wrapping.bridge import wrap_lines

#: Width at interface scale 1.
LINE_PIXELS = 2.0

#: Size of what ends a line of Wrap.
END_PIXELS = 8.0

_handler = None


def draw():
    """Called by Blender at every redraw: after a mistake of ours it is not called for ever more."""
    if overlay.problem:
        return
    try:
        obj = overlay.subject_to_draw(bpy.context)
        if obj is not None and len(obj.meanvalue.capture.pairs):
            _draw(bpy.context, obj, pair_lines.lines(obj))
        if obj is not None and wrap_lines.is_any(obj):
            _draw(bpy.context, obj, wrap_lines.lines(obj), END_PIXELS)
    except Exception as error:
        traceback.print_exc()
        overlay.problem = f"The overlay cannot be drawn: {error}. Please report this; the console has the details"


def _draw(context, obj, lines, end_pixels=0.0):
    if not len(lines.ends):
        return
    shader = compat.lines_shader()
    content = {"pos": lines.ends, "color": lines.colors}
    batch = batch_for_shader(shader, 'LINES', content)
    gpu.state.blend_set('ALPHA')
    gpu.state.depth_test_set('NONE')  # a line that ends inside the body is the one to be seen
    try:
        with gpu.matrix.push_pop():
            gpu.matrix.multiply_matrix(obj.matrix_world)
            shader.bind()
            shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
            shader.uniform_float("lineWidth", LINE_PIXELS * context.preferences.system.ui_scale)
            batch.draw(shader)
            if end_pixels:
                gpu.state.point_size_set(end_pixels * context.preferences.system.ui_scale)
                batch_for_shader(compat.points_shader(), 'POINTS', content).draw(compat.points_shader())
    finally:
        gpu.state.point_size_set(1.0)
        gpu.state.depth_test_set('NONE')
        gpu.state.blend_set('NONE')


def register():
    global _handler
    if not bpy.app.background:
        _handler = bpy.types.SpaceView3D.draw_handler_add(draw, (), 'WINDOW', 'POST_VIEW')


def unregister():
    global _handler
    if _handler is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_handler, 'WINDOW')
    _handler = None
