# SPDX-License-Identifier: GPL-3.0-or-later
"""What the overlay shows of Wrap: a line from each picked vertex to its place on the other object."""

import numpy as np
from mathutils import Vector

from ...scene import shown_shape, views
from ...widgets.overlay import NOTHING, Lines, draw_lines

#: Size of what ends a line, at interface scale 1.
END_PIXELS = 8.0

#: (name of an object, its vertex whose place is to be clicked next), or None.
begun = None


def paint(context, obj):
    draw_lines(context, obj, lines(obj), END_PIXELS)


def lines(obj):
    """The Lines of a mesh object, from where its vertices are to be seen now to where the other object is now.

    A vertex whose place is still missing has a line of no length.
    """
    settings = obj.meanvalue.wrap
    count = len(obj.data.vertices)
    pairs = [pair for pair in settings.pairs if pair.vertex < count] if settings.target is not None else []
    alone = [begun[1]] if begun is not None and begun[0] == obj.name and begun[1] < count else []
    if not pairs and not alone:
        return NOTHING
    points = shown_shape.positions(obj)[[*(pair.vertex for pair in pairs), *alone]]
    places = points.copy()
    if pairs:
        to_own = obj.matrix_world.inverted_safe() @ settings.target.matrix_world
        places[: len(pairs)] = [to_own @ Vector(pair.place) for pair in pairs]
    colors = np.array([(*views.COLORS[number % len(views.COLORS)], 1.0) for number in range(len(points))], np.float32)
    return Lines(np.stack([points, places], axis=1).reshape(-1, 3), np.repeat(colors, 2, axis=0))
