# SPDX-License-Identifier: GPL-3.0-or-later
"""What is to be solved: arrays that do not change any more, without Blender."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...posing.core.bind_input import BindInput
from ...solver.core.fingerprint import digest
from ..core import point_cache
from . import solving

#: Chunks have so many frames where they fit into the memory that one may take: several runs of the solver, so that
#: each of its threads has one. It depends on the mesh alone, so that another machine goes on with the same chunks.
CHUNK_FRAMES = 2 * solving.RUN_FRAMES
CHUNK_BYTES = 256 << 20


class Rows:
    """Mix-in: what all plans tell of their f samples. Subclasses have times, f float64: frames; spacing: frames from
    one to the next; vertices; key, a digest; and solve_rows()."""

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
        run_bytes = solving.RUN_FRAMES * self.header.row_bytes
        runs = max(1, min(CHUNK_FRAMES // solving.RUN_FRAMES, CHUNK_BYTES // max(1, run_bytes)))
        count = runs * solving.RUN_FRAMES
        return [(begin, min(begin + count, len(self.times))) for begin in range(0, len(self.times), count)]


@dataclass(frozen=True, eq=False)
class BakePlan(Rows):
    """Of handles. targets f x k x 3 and weights f x k or None as of bridge.sampling."""

    bind_input: BindInput
    times: np.ndarray
    spacing: float
    targets: np.ndarray
    weights: np.ndarray | None
    portable: bool = False  #: solved with the same bits on every processor of an architecture

    @cached_property
    def key(self):
        """Digest of all that the shapes depend on, and of the times that they belong to."""
        return digest(
            repr(self.bind_input.fingerprint.key),
            self.times,
            repr(self.spacing),
            self.targets,
            "all count" if self.weights is None else self.weights,
            f"{solving.version()} {solving.RUN_FRAMES} {solving.OVERLAP_FRAMES}{' portable' if self.portable else ''}",
            ", ".join(solving.REPORTED),
        )

    @property
    def vertices(self):
        return len(self.bind_input.rest)

    def solve_rows(self, binding, begin, end, execution, threads=0, resume=None):
        """Steps (see workers.job) to the solving.SolvedRows [begin, end), or to the solving.PausedRows, whose state
        `resume` takes. @throws SolverError, CancelledError."""
        return (
            yield from solving.solve_rows(
                binding, self.bind_input, self.targets, self.weights, begin, end, execution, threads, resume
            )
        )
