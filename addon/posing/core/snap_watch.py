# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a pose snaps, from its answers at frames that are gone through one by one."""

import numpy as np

from ...solver import native_loader

#: Frames to either side that tell whether a step is a snap, and the fewest in a row that tell anything.
ASIDE, FEWEST = 8, 6

#: Vertices and anchors that are looked at.
MOST_ROWS, MOST_ANCHORS = 2000, 100

#: Targets at the same frame that differ by more, as a share of the size, are of another animation.
SAME = 1e-4


class SnapWatch:
    """found: the frame that the pose snaps at from the one before, or None."""

    def __init__(self):
        self.found = None
        self._last = {}  # frame: (rows of the shape, targets of anchors, their weights)

    def note(self, frame, shape, targets, weights, diagonal):
        """shape: n x 3, the answer at this frame; targets, weights: k x 3, and k or None."""
        every = max(1, len(targets) // MOST_ANCHORS)
        asked = targets[::every], np.ones(len(targets[::every])) if weights is None else weights[::every]
        if frame in self._last and np.abs(asked[0] - self._last[frame][1]).max(initial=0.0) > SAME * diagonal:
            self._last, self.found = {}, None
        self._last[frame] = (shape[:: max(1, len(shape) // MOST_ROWS)].copy(), *asked)
        if not {frame - 1, frame + 1} & self._last.keys():
            self._last = {frame: self._last[frame]}
        frames = [each for each in sorted(self._last) if abs(each - frame) <= 2 * ASIDE]
        self._last = {each: self._last[each] for each in frames}
        if len(frames) < FEWEST:
            return
        shapes, targets, weights = (np.stack(each) for each in zip(*self._last.values(), strict=True))
        told = native_loader.module().find_snaps(shapes, targets, diagonal, weights=weights)
        near = [frames[0] + each for each in told if abs(frames[0] + each - frame) <= ASIDE]
        if near or (self.found is not None and abs(self.found - frame) <= ASIDE):
            self.found = max(near, default=None)
