# SPDX-License-Identifier: GPL-3.0-or-later
"""What is to be solved: arrays that do not change any more, without Blender."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...solver.core.fingerprint import digest
from ..core import point_cache
from .handle_clip import RUN_FRAMES

#: Chunks have so many frames where they fit into the memory that one may take: several runs of the solver, so that
#: each of its threads has one. It depends on the mesh alone, so that another machine goes on with the same chunks.
CHUNK_FRAMES = 2 * RUN_FRAMES
CHUNK_BYTES = 256 << 20


@dataclass(frozen=True, eq=False)
class BakePlan:
    """clip: of f frames, a HandleClip or RowClip; times: f float64, frames; spacing: frames from one to the next."""

    clip: object
    times: np.ndarray
    spacing: float

    @cached_property
    def key(self):
        """Digest of all that the shapes depend on, and of the times that they belong to."""
        return digest(self.clip.key, self.times, repr(self.spacing))

    @property
    def vertices(self):
        return self.clip.vertices

    @property
    def header(self):
        return point_cache.Header(self.vertices, float(self.times[0]), self.spacing, len(self.times))

    @property
    def numbers(self):
        """What chunks call the rows: the frames where every frame is sampled, else counted on from the first."""
        first = int(np.floor(self.times[0]))
        return range(first, first + len(self.times))

    def chunks(self):
        """[(begin, end)] rows."""
        run_bytes = RUN_FRAMES * self.header.row_bytes
        count = RUN_FRAMES * max(1, min(CHUNK_FRAMES // RUN_FRAMES, CHUNK_BYTES // max(1, run_bytes)))
        return [(begin, min(begin + count, len(self.times))) for begin in range(0, len(self.times), count)]
