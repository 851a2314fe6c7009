# SPDX-License-Identifier: GPL-3.0-or-later
"""What is drawn over the mesh that the artist works on, in 3D Views. Rooms draw it, and may draw lines from the mesh to
somewhere else."""

import collections
import contextlib
import traceback

import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

from .. import compat
from ..rooms import ALL
from ..scene import subject, views

#: In modes that are not here, Blender has a mesh of its own.
MODES = {'OBJECT', 'WEIGHT_PAINT', 'VERTEX_PAINT', 'TEXTURE_PAINT'}

#: Why nothing is drawn any more until the add-on is enabled again, or "".
problem = ""

_handler = None


def draw():
    """Called by Blender at every redraw of every 3D View: after a mistake of ours it is not called for ever more."""
    global problem
    if problem:
        return
    try:
        obj, space = subject.of(bpy.context), bpy.context.space_data
        if not space.overlay.show_overlays or subject.object_problem(obj) is not None or obj.mode not in MODES:
            return
        if obj.meanvalue.show_overlay and views.is_visible(obj, space):
            for paint in ALL.painters:
                paint(bpy.context, obj)
    except Exception as error:
        traceback.print_exc()
        problem = f"The overlay cannot be drawn: {error}. Please report this; the console has the details"


def register():
    global _handler, problem
    problem = ""
    if not bpy.app.background:
        _handler = bpy.types.SpaceView3D.draw_handler_add(draw, (), 'WINDOW', 'POST_VIEW')


def unregister():
    global _handler
    if _handler is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_handler, 'WINDOW')
    _handler = None


@contextlib.contextmanager
def drawing(context, obj, depth_test, point_pixels):
    """Inside, what is drawn is in the space of `obj`, and may be seen through; points are so large at scale 1."""
    wrote_depth = gpu.state.depth_mask_get()
    gpu.state.blend_set('ALPHA')
    gpu.state.depth_test_set(depth_test)
    gpu.state.depth_mask_set(False)
    gpu.state.point_size_set(point_pixels * context.preferences.system.ui_scale or 1.0)
    try:
        with gpu.matrix.push_pop():
            gpu.matrix.multiply_matrix(obj.matrix_world)
            yield
    finally:
        gpu.state.point_size_set(1.0)
        gpu.state.depth_mask_set(wrote_depth)
        gpu.state.depth_test_set('NONE')
        gpu.state.blend_set('NONE')


#: Width at interface scale 1.
LINE_PIXELS = 2.0


#: In object space: ends (2k, 3) float32, two for each line, with colors (2k, 4) float32.
Lines = collections.namedtuple("Lines", "ends colors")

NOTHING = Lines(np.empty((0, 3), np.float32), np.empty((0, 4), np.float32))


def draw_lines(context, obj, lines, end_pixels=0.0):
    """Draws Lines of a mesh object; end_pixels: size of what ends each, at interface scale 1, if not 0."""
    if not len(lines.ends):
        return
    shader = compat.shader("POLYLINE_FLAT_COLOR")
    content = {"pos": lines.ends, "color": lines.colors}
    batch = batch_for_shader(shader, 'LINES', content)
    with drawing(context, obj, 'NONE', end_pixels):  # a line that ends inside the body is the one to be seen
        shader.bind()
        shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
        shader.uniform_float("lineWidth", LINE_PIXELS * context.preferences.system.ui_scale)
        batch.draw(shader)
        if end_pixels:
            ends = compat.shader("POINT_FLAT_COLOR")
            batch_for_shader(ends, 'POINTS', content).draw(ends)
