# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines from a mesh to somewhere else, for painters of rooms.py."""

from dataclasses import dataclass

import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

from .. import compat

#: Width at interface scale 1.
LINE_PIXELS = 2.0


@dataclass(frozen=True, eq=False)
class Lines:
    """In object space: ends (2k, 3) float32, two for each line, with colors (2k, 4) float32."""

    ends: np.ndarray
    colors: np.ndarray


NOTHING = Lines(np.empty((0, 3), np.float32), np.empty((0, 4), np.float32))


def draw(context, obj, lines, end_pixels=0.0):
    """Draws Lines of a mesh object; end_pixels: size of what ends each, at interface scale 1, if not 0."""
    if not len(lines.ends):
        return
    shader = compat.shader("POLYLINE_FLAT_COLOR")
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
                ends = compat.shader("POINT_FLAT_COLOR")
                batch_for_shader(ends, 'POINTS', content).draw(ends)
    finally:
        gpu.state.point_size_set(1.0)
        gpu.state.depth_test_set('NONE')
        gpu.state.blend_set('NONE')
