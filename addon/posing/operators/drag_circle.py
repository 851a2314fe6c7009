# SPDX-License-Identifier: GPL-3.0-or-later
"""The circle around the mouse that shows how far the surroundings follow while something is dragged."""

import bpy
import gpu
from bpy_extras import view3d_utils
from gpu_extras.presets import draw_circle_2d
from mathutils import Vector

from ...scene import views

COLOR = (1.0, 1.0, 1.0, 0.8)

#: Pixels of the circle as long as nothing is known of what is pressed.
NOTICED = 12.0

#: Whether a circle is to be seen: the tool's own cursor stays away then.
is_shown = False


class DragCircle:
    """To be removed when the drag ends, however it ends."""

    def __init__(self):
        global is_shown
        self._center, self._radius, self._region = (0.0, 0.0), 0.0, 0
        self._handler = bpy.types.SpaceView3D.draw_handler_add(self._draw, (), 'WINDOW', 'POST_PIXEL')
        is_shown = True

    def show(self, region, view, mouse, place=None, length=0.0):
        """Around `mouse` (2, pixels in the region), of so much length in the world at `place`; 0: none. Without a
        place it only says that the press was noticed."""
        self._center, self._region = tuple(mouse), region.as_pointer()
        self._radius = NOTICED if place is None else pixels(region, view, place, length)
        views.draw_again('WINDOW')

    def remove(self):
        global is_shown
        is_shown = False
        if self._handler is not None:
            bpy.types.SpaceView3D.draw_handler_remove(self._handler, 'WINDOW')
            self._handler = None
            views.draw_again('WINDOW')

    def _draw(self):
        if bpy.context.region.as_pointer() == self._region and self._radius > 0.0:
            draw(self._center, COLOR, self._radius)


def draw(center, color, radius):
    """In pixels of the region that is drawn."""
    gpu.state.blend_set('ALPHA')
    draw_circle_2d(center, color, radius, segments=64)
    gpu.state.blend_set('NONE')


def pixels(region, view, place, length):
    """How many pixels a length in the world is at `place`."""
    middle = view3d_utils.location_3d_to_region_2d(region, view, place)
    across = view.view_rotation @ Vector((length, 0.0, 0.0))
    beside = view3d_utils.location_3d_to_region_2d(region, view, place + across)
    return 0.0 if middle is None or beside is None else (beside - middle).length
