# SPDX-License-Identifier: GPL-3.0-or-later
"""What Bake reads of a kind of scene/bakeable.py at each frame, and solves, each frame for itself."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...errors import SolverError
from ...solver import native_loader
from ...solver.core.fingerprint import digest
from ..core.bake_report import REPORTED
from .handle_clip import REVISION


class Source:
    """posing: what binds. begin() is called before `count` frames are read, read() at each, then clip()."""

    def __init__(self, kind, obj):
        self._kind = kind
        self.posing = kind.bind(obj)
        self._rows = None

    def begin(self, _obj, count):
        self._rows = [None] * count

    def read(self, obj, row):
        """@throws SceneError."""
        self._rows[row] = self._kind.row(obj, self.posing.bind_input)

    def clip(self):
        return RowClip(self._kind, self.posing.bind_input, np.array(self._rows))

    def notes(self, _obj):
        """Sentences on what an artist may not expect."""
        return ()


@dataclass(frozen=True, eq=False)
class RowClip:
    """rows: f x k float64. As HandleClip."""

    kind: object
    bind_input: object
    rows: np.ndarray

    @cached_property
    def key(self):
        return digest(self.bind_input.revision, self.rows, f"{native_loader.module().__version__} {REVISION}")

    @property
    def vertices(self):
        return len(self.bind_input.rest)

    def solve_rows(self, binding, begin, end, execution, _threads=0):
        """Steps as of HandleClip. @throws CancelledError."""
        shapes, report = [], {name: [] for name in REPORTED}
        shape = self.bind_input.rest
        for row in range(begin, end):
            energy, iterations, converged, problem = None, 0, False, ""
            try:
                solved = yield from self.kind.solve_steps(binding, self.bind_input, self.rows[row], execution)
                shape, iterations, converged = solved.positions.astype(np.float32), solved.iterations, solved.converged
                energy = solved.energy / self.bind_input.diagonal**2
            except SolverError as error:
                problem = str(error)
            shapes.append(shape)
            for name, value in zip(REPORTED, (0.0, energy, iterations, converged, problem), strict=True):
                report[name].append(value)
        return np.array(shapes), report
