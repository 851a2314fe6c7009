# SPDX-License-Identifier: GPL-3.0-or-later
"""Solves rows of a sequence. The one place of the add-on that knows how the solver takes sequences."""

from dataclasses import dataclass

import numpy as np

from .. import session
from ..core import result
from ..errors import SolverError

#: Rows are solved in runs that are aligned to the first row of the clip and begin cold so many rows before, so that no
#: row depends on which part was asked for.
RUN_FRAMES = 48
OVERLAP_FRAMES = 8


@dataclass(frozen=True, eq=False)
class SolvedRows:
    """vertices r x n x 3 float32, with all fixed vertices in place; report {name: r values}, see core.bake_report."""

    vertices: np.ndarray
    report: dict


def solve_rows(binding, bind_input, targets, weights, begin, end, execution, threads=0):
    """Steps (see workers.job) to the SolvedRows [begin, end) of a clip. targets f x k x 3 and weights of the whole clip.

    @throws SolverError, CancelledError.
    """
    vertices = np.empty((end - begin, len(bind_input.rest), 3), np.float32)
    report = {"energies": [], "iterations": [], "converged": [], "errors": []}
    for run in range(begin // RUN_FRAMES, (end - 1) // RUN_FRAMES + 1):
        shape = None
        for row in range(max(0, run * RUN_FRAMES - OVERLAP_FRAMES), min(end, (run + 1) * RUN_FRAMES)):
            error, summary = "", None
            try:
                shape, summary = yield from session.solve_steps(
                    binding, bind_input, targets[row], start=shape, execution=execution
                )
            except SolverError as failure:
                error = str(failure)
            if row < max(begin, run * RUN_FRAMES):
                continue
            shown = bind_input.rest if shape is None else shape
            vertices[row - begin] = result.compose(bind_input, targets[row], shown)
            report["energies"].append(summary.energy if summary else None)
            report["iterations"].append(summary.iterations if summary else 0)
            report["converged"].append(bool(summary and summary.converged))
            report["errors"].append(error)
    return SolvedRows(vertices, report)
