# SPDX-License-Identifier: GPL-3.0-or-later
"""What the overlay shows of motion capture: a line from each marker, at the reference frame, to its point."""

import numpy as np

from ...scene import shown_shape
from ...widgets.overlay import NOTHING, Lines, draw_lines
from . import marker_pairs

#: Near, middling, far: told apart by most eyes (Okabe and Ito 2008).
SCALE_COLORS = np.array([(0.0, 0.62, 0.45, 1.0), (0.94, 0.89, 0.26, 1.0), (0.84, 0.30, 0.0, 1.0)], np.float32)

#: Distance that has the last color, as a share of the mesh's size: on a person some 12 cm.
FAR = 0.05

ACTIVE_COLOR = (1.0, 1.0, 1.0, 1.0)


def lines(obj):
    """The Lines of a mesh object, where its vertices are to be seen now."""
    capture = obj.meanvalue.capture
    pairs = [pair for pair in capture.pairs if pair.distance >= 0.0 and 0 <= pair.vertex < len(obj.data.vertices)]
    if not pairs:
        return NOTHING
    points = shown_shape.positions(obj)[[pair.vertex for pair in pairs]]
    offsets = np.array([pair.offset for pair in pairs], np.float32)
    shares = np.linalg.norm(offsets, axis=1) / max(capture.mesh_size, 1e-30)
    place, stops = np.clip(shares / FAR, 0.0, 1.0) * (len(SCALE_COLORS) - 1), np.arange(len(SCALE_COLORS))
    colors = np.stack([np.interp(place, stops, channel) for channel in SCALE_COLORS.T], axis=1).astype(np.float32)
    active = marker_pairs.active_pair(obj)
    colors[[pair == active for pair in pairs]] = ACTIVE_COLOR
    return Lines(np.stack([points, points + offsets], axis=1).reshape(-1, 3), np.repeat(colors, 2, axis=0))


def paint(context, obj):
    if len(obj.meanvalue.capture.pairs):
        draw_lines(context, obj, lines(obj))
