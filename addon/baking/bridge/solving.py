# SPDX-License-Identifier: GPL-3.0-or-later
"""Solves rows of a clip: the solver's Sequence, with a report that can be kept in a file."""

from dataclasses import dataclass

import numpy as np

from ...solver import native_loader, session

#: The solver's `chunk` and `overlap`: a row's bits depend on them, on the whole clip and on nothing else.
RUN_FRAMES = 48
OVERLAP_FRAMES = 12
#: Raised by one when the solver makes other shapes of the same clip.
REVISION = 6

#: What is told of each row, see core.bake_report.
REPORTED = ("distances", "energies", "iterations", "converged", "errors")

NOT_NUMBERS = "the solver gave positions that are not numbers"


def version():
    """By what shapes are made: where this is another one, shapes of a bake that was stopped are not gone on with."""
    return f"{native_loader.module().__version__} {REVISION}"


@dataclass(frozen=True, eq=False)
class SolvedRows:
    """vertices r x n x 3 float32; report {name: list of r values}, see core.bake_report."""

    vertices: np.ndarray
    report: dict


@dataclass(frozen=True, eq=False)
class PausedRows:
    """Rows that execution.pause() stopped on their way.

    state: (b,) uint8, to go on from, for the same bytes in the end; solved: r bool, rows that are not solved again.
    """

    state: np.ndarray
    solved: np.ndarray


def solve_rows(binding, bind_input, targets, weights, begin, end, execution, threads=0, resume=None):
    """Steps (see workers.job) to the SolvedRows [begin, end), or to PausedRows, whose state `resume` takes.

    targets f x k x 3 and weights are of the whole clip.

    A row that cannot be solved has the shape of the one before it, and its error in the report.

    @throws SolverError, CancelledError.
    """
    vertices, sequence = yield from session.sequence_steps(
        binding,
        bind_input,
        targets,
        weights,
        frames=(begin, end),
        chunk=RUN_FRAMES,
        overlap=OVERLAP_FRAMES,
        threads=threads,
        resume=resume,
        execution=execution,
    )
    if sequence.is_paused:
        return PausedRows(np.array(sequence.state), np.array(sequence.solved))
    errors = [""] * (end - begin)
    for row in range(end - begin):
        if not np.isfinite(vertices[row]).all():
            errors[row] = NOT_NUMBERS
    for row, message in sequence.errors:
        errors[row - begin] = message
    energies = (np.asarray(sequence.energies) / bind_input.solver_mesh.diagonal**2).tolist()
    wanted = bind_input.solver_mesh.met(targets[begin:end])
    report = {
        "distances": _distances(vertices[:, bind_input.anchors], wanted, weights, begin).tolist(),
        "energies": [energy if np.isfinite(energy) else None for energy in energies],
        "iterations": [int(count) for count in sequence.iterations],
        "converged": [bool(is_converged) for is_converged in sequence.converged],
        "errors": errors,
    }
    assert tuple(report) == REPORTED
    return SolvedRows(vertices, report)


def _distances(placed, wanted, weights, begin):
    """r float64: how far the farthest anchor is from its target, in the object's own units; less if it counts less."""
    distances = np.linalg.norm(placed.astype(np.float64) - wanted, axis=2)
    if weights is not None:
        counts = weights[begin : begin + len(wanted)]
        distances = counts * np.where(counts > 0.0, distances, 0.0)
    return np.nan_to_num(distances.max(axis=1, initial=0.0))
