# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a pose snaps, from its answers at frames that are gone through one by one."""

import numpy as np

#: Shares of the mesh's size, of the step itself, and of what the handles ask for, that the step of a snap exceeds the
#: two beside it by.
SEEN, SHARP, ASKED = 0.02, 0.5, 2.5

#: Vertices that are looked at.
MOST_ROWS = 2000


class SnapWatch:
    """found: the frame that the pose snaps at from the one before, or None."""

    def __init__(self):
        self.found = None
        self._last = []  # (frame, rows of the shape, rows of its anchors), frame by frame

    def note(self, frame, shape, anchors, diagonal):
        """shape: n x 3, the answer at this frame; anchors: vertices."""
        rows = [some[:: max(1, len(some) // MOST_ROWS)] for some in (shape, shape[anchors])]
        last = [each for each in self._last if each[0] != frame]
        way = frame - last[-1][0] if last else 0
        if abs(way) != 1 or (len(last) > 1 and last[-1][0] - last[-2][0] != way):
            last = last[-1:] if abs(way) == 1 else []
        self._last = [*last, (frame, *rows)][-4:]
        if len(self._last) < 4:
            return
        frames, *shapes = zip(*self._last, strict=True)
        steps, asked = (np.diff(each, axis=0) for each in shapes)
        excess, limit = (np.linalg.norm(each[1] - 0.5 * (each[0] + each[2]), axis=1) for each in (steps, asked))
        most = excess.argmax()
        least = max(SEEN * diagonal, SHARP * np.linalg.norm(steps[1, most]), ASKED * limit.max(initial=0.0))
        if excess[most] > least:
            self.found = max(frames[1:3])
        elif self.found == max(frames[1:3]):
            self.found = None
