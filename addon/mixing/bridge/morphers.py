# SPDX-License-Identifier: GPL-3.0-or-later
"""What mixes hand to the solver, and what it makes of them; session.py keeps what was bound."""

import collections
import re

import numpy as np

from ...errors import ChangedMeanwhileError, SolverError
from ...solver import native_loader, session
from ..core import in_betweens
from . import mixed_keys

REFUSED_SHAPES = "The solver cannot mix these shape keys: {}"


#: positions n x 3 float64; seconds that the solver took.
Mix = collections.namedtuple("Mix", "positions converged seconds")


def bind_steps(mix_input, execution):
    """Steps (see solver/job.py) to a native Morpher, which is kept. @throws NativeModuleError, SolverError,
    CancelledError."""
    whole = mix_input.whole
    shapes = [whole.start(shape) for shape in (mix_input.rest, *(mix_input.points[name] for name in mix_input.names))]
    try:
        morpher = yield from session.steps(
            native_loader.module().start_bind_morph,
            np.array(shapes),
            whole.triangles(mix_input.triangles),
            execution=execution,
            refused=REFUSED_SHAPES,
        )
    except SolverError as error:
        names = ["the rest shape", *(f"'{name}'" for name in mix_input.names)]
        raise SolverError(re.sub(r"shapes\[(\d+)\]", lambda found: names[int(found[1])], str(error))) from error
    session.cache.put(mix_input.key, morpher, int(morpher.report.bytes))
    return morpher


def solve_steps(morpher, mix_input, values, execution=None):
    """Steps to the Mix with the sliders at `values`, (k,).

    The same for the same values. Where one shape alone is wanted, it is that to the bit.

    @throws SolverError, CancelledError.
    """
    weights = mix_input.weights(values)
    if weights.ndim == 1 and np.count_nonzero(weights) == 1 and weights.max() == 1.0:
        shape = mix_input.points[mix_input.names[weights.argmax() - 1]] if weights[0] == 0.0 else mix_input.rest
        return Mix(shape.astype(np.float64), True, 0.0)
    solution = yield from session.steps(
        morpher.start_solve,
        weights if weights.ndim == 1 else mix_input.whole.values(weights),
        parts=mix_input.parts,
        execution=execution,
        refused=REFUSED_SHAPES,
    )
    return Mix(
        positions=mix_input.whole.cut_back(session.finite(solution.vertices, "Move the sliders closer to 0")),
        converged=bool(solution.converged),
        seconds=float(solution.timings["total"]),
    )


class Mixing:
    """As widgets/background.py wants it: binds what is mixed. bind_input: the MixInput; binding: the Morpher."""

    def __init__(self, mix_input):
        self.bind_input = mix_input
        self.binding = session.cache.get(mix_input.key)

    def record(self, _obj):
        """The file keeps no binding of a mix."""

    def work(self, execution):
        """Steps (see solver/job.py) that bind. @throws MeanValueError."""
        if self.binding is None:
            self.binding = yield from bind_steps(self.bind_input, execution)

    def require_unchanged(self, obj):
        """@throws ChangedMeanwhileError if the shape keys are others by now."""
        if mixed_keys.problem(obj) is None and mixed_keys.gather(obj).revision == self.bind_input.revision:
            return
        raise ChangedMeanwhileError(obj.name)


#: In-between keys that are made at most.
MOST_KEYS = 60


class InBetweenSearch(Mixing):
    """Finds the in-between keys. solved: mixes that were solved so far."""

    def __init__(self, mix_input, tolerance):
        super().__init__(mix_input)
        self.tolerance = tolerance
        self.solved = 0

    def work(self, execution):
        """Steps (see solver/job.py) to a Found. @throws MeanValueError."""
        yield from super().work(execution)
        mix_input = self.bind_input
        ranges = [(slider.low, slider.high) for slider in mix_input.sliders]

        def correction(values):
            mix = yield from solve_steps(self.binding, mix_input, values, execution)
            self.solved += 1
            return mix.positions - mix_input.mixed(values)

        return (yield from in_betweens.found(correction, ranges, self.tolerance, MOST_KEYS, mix_input.common))
