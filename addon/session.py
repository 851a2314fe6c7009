# SPDX-License-Identifier: GPL-3.0-or-later
"""The compiled deformers of this session and the calls into them.

Deformers are a cache of what the scene already says: nothing is lost when one is dropped, and nothing here holds
a Blender object.
"""

import time
from dataclasses import dataclass

import numpy as np

from . import ids, native_loader
from .core import result
from .core.deformer_cache import DeformerCache
from .errors import SceneError, SolverError

CACHE_ENTRIES = 4
CACHE_BYTES = 2 << 30

_cache = DeformerCache(CACHE_ENTRIES, CACHE_BYTES)


@dataclass(frozen=True)
class Binding:
    """A native deformer and how long it took to make."""

    deformer: object
    summary: result.BindSummary


def binding_for(bind_input, triangles):
    """The Binding of `bind_input`, from the cache or newly made. `triangles()` gives m x 3 int32 when needed.

    @throws NativeModuleError, SceneError, SolverError; then nothing is cached.
    """
    key = bind_input.fingerprint.key
    binding = _cache.get(key)
    if binding is None:
        binding = _bind(bind_input, triangles())
        _cache.put(key, binding, int(binding.deformer.report.bytes))
    return binding


def solve(binding, bind_input, targets):
    """(n x 3 float64 positions, SolveSummary) for k x 3 `targets` in the order of `bind_input.anchors`.

    @throws SolverError.
    """
    started = time.perf_counter()
    solution = _call(binding.deformer.solve, np.ascontiguousarray(targets, np.float64))
    summary = result.SolveSummary.of(solution, bind_input.diagonal, time.perf_counter() - started)
    if not result.all_finite(solution.vertices):
        raise SolverError(
            f"The solver gave positions that are not numbers ({summary.text()}). Move the anchors closer to the rest "
            "shape, or add anchors"
        )
    return solution.vertices, summary


def forget(fingerprint):
    _cache.discard(fingerprint.key)


def clear():
    _cache.clear()


def _bind(bind_input, triangles):
    module = native_loader.module()
    started = time.perf_counter()
    deformer = _call(
        module.Deformer,
        bind_input.rest.astype(np.float64),
        triangles,
        bind_input.anchors,
        roi=None if bind_input.roi.all() else bind_input.roi,
        method=ids.METHOD,
    )
    summary = result.BindSummary.of(deformer.report, time.perf_counter() - started)
    if result.nothing_is_held(deformer.report):
        raise SceneError(
            "No part of the mesh that may move has three fixed points that are not in one line, so nothing can be "
            "posed. Give the part three anchors, or choose a region that leaves some of its vertices out"
        )
    return Binding(deformer, summary)


def _call(function, *arguments, **options):
    """Calls the native module; its errors become ours, with what to do."""
    module = native_loader.module()
    try:
        return function(*arguments, **options)
    except module.InvalidInput as error:
        raise SolverError(
            f"The solver cannot use this mesh: {error}. Correct the mesh there and press Bind"
        ) from error
    except module.SolverFailure as error:
        raise SolverError(
            f"The solver failed: {error}. Move the anchors closer to the rest shape, or add anchors"
        ) from error
    except module.Cancelled as error:
        raise SolverError("Cancelled; nothing was changed") from error
    except MemoryError as error:
        raise SolverError(
            "There is not enough memory for this mesh. Choose a smaller region, or close other programs"
        ) from error
