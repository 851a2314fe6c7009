# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the lines from markers to their points on the mesh. What is drawn comes from bridge/pair_lines.py."""

import traceback

import bpy
import gpu
from gpu_extras.batch import batch_for_shader

from .. import compat
from ..bridge import pair_lines
from . import overlay

#: Width at interface scale 1.
LINE_PIXELS = 2.0

_handler = None


def draw():
    """Called by Blender at every redraw: after a mistake of ours it is not called for ever more."""
    if overlay.problem:
        return
    try:
        obj = overlay.subject_to_draw(bpy.context)
        if obj is not None and len(obj.meanvalue.capture.pairs):
            _draw(bpy.context, obj, pair_lines.lines(obj))
    except Exception as error:
        traceback.print_exc()
        overlay.problem = f"The overlay cannot be drawn: {error}. Please report this; the console has the details"


def _draw(context, obj, lines):
    if not len(lines.ends):
        return
    shader = compat.lines_shader()
    batch = batch_for_shader(shader, 'LINES', {"pos": lines.ends, "color": lines.colors})
    gpu.state.blend_set('ALPHA')
    gpu.state.depth_test_set('NONE')  # a line that ends inside the body is the one to be seen
    try:
        with gpu.matrix.push_pop():
            gpu.matrix.multiply_matrix(obj.matrix_world)
            shader.bind()
            shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
            shader.uniform_float("lineWidth", LINE_PIXELS * context.preferences.system.ui_scale)
            batch.draw(shader)
    finally:
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
