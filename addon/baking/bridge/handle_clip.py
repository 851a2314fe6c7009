# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles over time, to be solved in parts: the solver's Sequence, with a report that can be kept in a file."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...posing.core.bind_input import BindInput
from ...solver import native_loader, session
from ...solver.core.fingerprint import digest
from ..core.bake_report import REPORTED

#: The solver's `chunk` and `overlap`: a row's bits depend on them, on the whole clip and on nothing else.
RUN_FRAMES = 48
OVERLAP_FRAMES = 12
#: Raised by one when the solver makes other shapes of the same clip.
REVISION = 6

NOT_NUMBERS = "the solver gave positions that are not numbers"


@dataclass(frozen=True, eq=False)
class HandleClip:
    """Of f frames and k anchors, in the order of `bind_input.anchors`.

    targets   f x k x 3 float64, in the object's own space at that frame
    weights   f x k float64, 0 to 1; None where all are 1
    portable  solved with the same bits on every processor of an architecture
    """

    bind_input: BindInput
    targets: np.ndarray
    weights: np.ndarray | None
    portable: bool = False

    @cached_property
    def key(self):
        """Digest of all that the shapes depend on."""
        return digest(
            repr(self.bind_input.fingerprint.key),
            self.targets,
            "all count" if self.weights is None else self.weights,
            f"{native_loader.module().__version__} {REVISION} {RUN_FRAMES} {OVERLAP_FRAMES} {self.portable}",
        )

    @property
    def vertices(self):
        return len(self.bind_input.rest)

    def solve_rows(self, binding, begin, end, execution, threads=0):
        """Steps (see solver/job.py) to (rows [begin, end), r x n x 3 float32, and their report).

        A row that cannot be solved has the shape of the one before it, and its error in the report.

        @throws SolverError, CancelledError.
        """
        vertices, sequence = yield from session.sequence_steps(
            binding,
            self.bind_input,
            self.targets,
            self.weights,
            frames=(begin, end),
            chunk=RUN_FRAMES,
            overlap=OVERLAP_FRAMES,
            threads=threads,
            execution=execution,
        )
        errors = ["" if np.isfinite(row).all() else NOT_NUMBERS for row in vertices]
        for row, message in sequence.errors:
            errors[row - begin] = message
        energies = (np.asarray(sequence.energies) / self.bind_input.solver_mesh.diagonal**2).tolist()
        columns = (
            self._distances(vertices, begin, end).tolist(),
            [energy if np.isfinite(energy) else None for energy in energies],
            [int(count) for count in sequence.iterations],
            [bool(is_converged) for is_converged in sequence.converged],
            errors,
        )
        return vertices, dict(zip(REPORTED, columns, strict=True))

    def _distances(self, vertices, begin, end):
        """r float64: how far the farthest anchor is from its target, in the object's own units; less if it counts
        less."""
        placed = vertices[:, self.bind_input.anchors].astype(np.float64)
        distances = np.linalg.norm(placed - self.bind_input.solver_mesh.met(self.targets[begin:end]), axis=2)
        if self.weights is not None:
            counts = self.weights[begin:end]
            distances = counts * np.where(counts > 0.0, distances, 0.0)
        return np.nan_to_num(distances.max(axis=1, initial=0.0))
