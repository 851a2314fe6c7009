# SPDX-License-Identifier: GPL-3.0-or-later
"""The compiled morphers of this session and the calls into them, as session.py for deformers."""

from dataclasses import dataclass

import numpy as np

from . import native_loader, session
from .core import result
from .core.deformer_cache import DeformerCache
from .errors import SolverError

REFUSED_SHAPES = "The solver cannot mix these shape keys: {}"

CACHE_ENTRIES = 2
CACHE_BYTES = 2 << 30

_cache = DeformerCache(CACHE_ENTRIES, CACHE_BYTES)


@dataclass(frozen=True, eq=False)
class Mix:
    """positions n x 3 float64; energy in the units of the mesh."""

    positions: np.ndarray
    energy: float
    iterations: int
    converged: bool


def cached(mix_input):
    """The native Morpher of `mix_input` if it is at hand, else None."""
    return _cache.get(mix_input.key)


def remember(mix_input, morpher):
    _cache.put(mix_input.key, morpher, int(morpher.report.bytes))


def bind_steps(mix_input, execution):
    """Steps (see workers.job) to a native Morpher. @throws NativeModuleError, SolverError, CancelledError."""
    shapes = np.concatenate([mix_input.rest[None], mix_input.shapes]).astype(np.float64)
    task = session.call(
        native_loader.module().start_bind_morph,
        shapes,
        mix_input.triangles,
        rigidity=mix_input.rigidity,
        execution=execution,
        refused=REFUSED_SHAPES,
    )
    yield task
    return session.call(task.result, refused=REFUSED_SHAPES)


def solve_steps(morpher, mix_input, values, execution=None, is_draft=False):
    """Steps to the Mix with the sliders at `values`, (k,).

    The same for the same values, whatever was solved before; but a draft, for sliders that are being dragged, goes on
    from the last solve in a few iterations. Where one shape alone is wanted, it is that to the bit.

    @throws SolverError, CancelledError.
    """
    weights = mix_input.weights(values)
    if weights.ndim == 1 and np.count_nonzero(weights) == 1 and weights.max() == 1.0:
        shape = mix_input.shapes[weights.argmax() - 1] if weights[0] == 0.0 else mix_input.rest
        return Mix(shape.astype(np.float64), 0.0, 0, True)
    task = session.call(morpher.start_solve, weights, draft=is_draft, execution=execution, refused=REFUSED_SHAPES)
    yield task
    solution = session.call(task.result, refused=REFUSED_SHAPES)
    if not result.all_finite(solution.vertices):
        raise SolverError("The solver gave positions that are not numbers. Move the sliders closer to 0")
    return Mix(solution.vertices, float(solution.energy), int(solution.iterations), bool(solution.converged))


def clear():
    _cache.clear()
