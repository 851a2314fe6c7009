# SPDX-License-Identifier: GPL-3.0-or-later
"""What the overlay shows of Wrap: a line from each picked vertex to its place on the other object."""

import numpy as np
from mathutils import Vector

from ...scene import shown_shape
from ...widgets.lines import NOTHING, Lines, draw

#: One after the other, so that lines that cross are told apart (Okabe and Ito 2008).
COLORS = np.array(
    [
        (0.94, 0.89, 0.26, 1.0),
        (0.34, 0.71, 0.91, 1.0),
        (0.84, 0.37, 0.0, 1.0),
        (0.0, 0.62, 0.45, 1.0),
        (0.80, 0.47, 0.65, 1.0),
        (0.90, 0.62, 0.0, 1.0),
    ],
    np.float32,
)

#: Size of what ends a line, at interface scale 1.
END_PIXELS = 8.0

#: (name of an object, its vertex whose place is to be clicked next), or None.
begun = None


def paint(context, obj):
    draw(context, obj, lines(obj), END_PIXELS)


def lines(obj):
    """The Lines of a mesh object, from where its vertices are to be seen now to where the other object is now.

    A vertex whose place is still missing has a line of no length.
    """
    settings = obj.meanvalue.wrap
    if not settings.show_pairs:
        return NOTHING
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
    colors = COLORS[np.arange(len(points)) % len(COLORS)]
    return Lines(np.stack([points, places], axis=1).reshape(-1, 3), np.repeat(colors, 2, axis=0))
