# SPDX-License-Identifier: GPL-3.0-or-later
"""What is to be solved: arrays that do not change any more, without Blender."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...errors import SolverError
from ...posing.core.bind_input import BindInput
from ...solver import native_loader, session
from ...solver.core.fingerprint import digest
from ..core import bake_times, point_cache

#: The solver's `chunk` and `overlap`: a row's bits depend on them, on the whole clip and on nothing else.
RUN_FRAMES = 48
OVERLAP_FRAMES = 12
#: Raised by one when the solver makes other shapes of the same clip.
REVISION = 12

#: Chunks have so many frames where they fit into the memory that one may take: several runs of the solver, so that
#: each of its threads has one. It depends on the mesh alone, so that another machine goes on with the same chunks.
CHUNK_FRAMES = 2 * RUN_FRAMES
CHUNK_BYTES = 256 << 20

#: What is said of a frame.
FAILED = "could not be solved, so the shape of the one before is there: {}"
EARLY = "stopped before it had converged. Have a look"


@dataclass(frozen=True, eq=False)
class HandleClip:
    """Handles over f frames: k anchors, in the order of `bind_input.anchors`."""

    bind_input: BindInput
    targets: np.ndarray  # f x k x 3 float64, in the object's own space at that frame
    weights: np.ndarray | None  # f x k float64, 0 to 1; None where all are 1
    portable: bool = False  # solved with the same bits on every processor of an architecture
    kept: tuple = ()  # rows, ascending, that no snap beside them is spread over: the artist's keys
    counts: np.ndarray | None = None  # f x (1 + s) float64 of the pose and what is beside it; None: the pose, fully
    beside: np.ndarray | None = None  # s x n x 3 float32: what shape keys add at 1

    @property
    def key(self):
        """Digest of all that the shapes depend on."""
        return digest(
            repr(self.bind_input.fingerprint),
            self.targets,
            self.weights,
            f"{native_loader.module().__version__} {REVISION} {RUN_FRAMES} {OVERLAP_FRAMES} {self.portable}",
            f"{list(map(int, self.kept))}",
            *(() if self.counts is None else (self.counts, self.beside)),
        )

    def solve_rows(self, binding, begin, end, execution, threads=0):
        """Steps (see solver/job.py) to (rows [begin, end), r x n x 3 float32, and r texts: what went wrong, or "").

        A row that cannot be solved has the shape of the one before it. @throws SolverError, CancelledError.
        """
        vertices, sequence = yield from session.sequence_steps(
            binding,
            self.bind_input,
            self.targets,
            self.weights,
            frames=(begin, end),
            chunk=RUN_FRAMES,
            overlap=OVERLAP_FRAMES,
            kept=list(map(int, self.kept)),
            threads=threads,
            execution=execution,
        )
        problems = ["" if is_converged else EARLY for is_converged in sequence.converged]
        for row in sequence.snaps:
            problems[row - begin] = bake_times.SNAPS
        for row, message in sequence.errors:
            problems[row - begin] = FAILED.format(message)
        if self.counts is not None:
            counts, rest = self.counts[begin:end, :, None, None].astype(np.float32), self.bind_input.rest
            vertices = rest + counts[:, 0] * (vertices - rest)
            vertices += sum(counts[:, number] * offset for number, offset in enumerate(self.beside, 1))
        return vertices, problems


@dataclass(frozen=True, eq=False)
class RowClip:
    """rows: f x k float64 of a rooms.Bakeable, each solved for itself. As HandleClip."""

    kind: object
    bind_input: object
    rows: np.ndarray

    @property
    def key(self):
        return digest(self.bind_input.revision, self.rows, f"{native_loader.module().__version__} {REVISION}")

    def solve_rows(self, binding, begin, end, execution):
        """Steps as of HandleClip. @throws CancelledError."""
        shapes, problems = [], []
        shape = self.bind_input.rest
        for row in range(begin, end):
            problem = ""
            try:
                solved = yield from self.kind.solve_steps(binding, self.bind_input, self.rows[row], execution)
                shape, problem = solved.positions.astype(np.float32), "" if solved.converged else EARLY
            except SolverError as error:
                problem = FAILED.format(error)
            shapes.append(shape)
            problems.append(problem)
        return np.array(shapes), problems


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
    def header(self):
        return self.header_of(len(self.clip.bind_input.rest))

    def header_of(self, vertices):
        return point_cache.Header(vertices, float(self.times[0]), self.spacing, len(self.times))

    def chunks(self):
        """[(begin, end)] rows."""
        count = CHUNK_FRAMES if CHUNK_FRAMES * self.header.row_bytes <= CHUNK_BYTES else RUN_FRAMES
        return [(begin, min(begin + count, len(self.times))) for begin in range(0, len(self.times), count)]
