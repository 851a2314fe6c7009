# SPDX-License-Identifier: GPL-3.0-or-later
"""Animated sliders of a rotation-aware mix, to be solved frame by frame."""

import io
import json
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...errors import CancelledError, SolverError
from ...mixing.bridge import mix_session
from ...mixing.core.mix_input import MixInput
from ...solver.core.fingerprint import digest
from . import solving
from .plan import Rows


@dataclass(frozen=True, eq=False)
class MixPlan(Rows):
    """values: f x k float64, the sliders in the order of the layers. Each frame is solved for itself."""

    mix_input: MixInput
    times: np.ndarray
    spacing: float
    values: np.ndarray

    @cached_property
    def key(self):
        """Digest of all that the shapes depend on, and of the times that they belong to."""
        return digest(
            self.mix_input.revision,
            self.times,
            repr(self.spacing),
            self.values,
            solving.version(),
            ", ".join(solving.REPORTED),
        )

    @property
    def vertices(self):
        return len(self.mix_input.rest)

    def solve_rows(self, morpher, begin, end, execution, _threads=0, resume=None):
        """Steps (see workers.job) to the solving.SolvedRows [begin, end), or PausedRows, whose state `resume` takes.

        A row that cannot be solved has the shape of the one before it, and its error in the report.

        @throws CancelledError.
        """
        rows, report = [], {name: [] for name in solving.REPORTED}
        if resume is not None:
            kept, report = _read_state(resume)
            rows = list(kept)
        before = rows[-1] if rows else self.mix_input.rest
        for row in range(begin + len(rows), end):
            if execution is not None and execution.pausing:
                solved = np.arange(end - begin) < len(rows)
                return solving.PausedRows(_state(np.array(rows, np.float32), report), solved)
            error, mix = "", None
            try:
                mix = yield from mix_session.solve_steps(morpher, self.mix_input, self.values[row], execution)
                before = mix.positions.astype(np.float32)
            except CancelledError:
                raise
            except SolverError as problem:
                error = str(problem)
            rows.append(before)
            report["distances"].append(0.0)
            report["energies"].append(None if mix is None else mix.energy / self.mix_input.diagonal**2)
            report["iterations"].append(0 if mix is None else mix.iterations)
            report["converged"].append(mix is not None and mix.converged)
            report["errors"].append(error)
        return solving.SolvedRows(np.array(rows), report)


def _state(rows, report):
    """(b,) uint8 of what was solved so far."""
    file = io.BytesIO()
    np.savez(file, rows=rows, report=json.dumps(report))
    return np.frombuffer(file.getvalue(), np.uint8)


def _read_state(state):
    """(rows, report) of _state()."""
    with np.load(io.BytesIO(state.tobytes())) as kept:
        return kept["rows"], json.loads(str(kept["report"]))
