# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a scalar field is zero, as a mesh of quads: surface nets (Gibson 1998). Needs numpy alone."""

import numpy as np

from native.benchmarks.generated_creature import nets

ROUNDS = 12
CHUNK = 100_000


def of_field(field, low, high, spacing, near=None):
    """(vertices (n, 3), quads (q, 4)), outward, of the zero of field((k, 3)) -> (k,), negative inside.

    The grid goes from low to high (3,); the surface must not reach its border. near((k, 3)) -> (k,) of bool: where the
    field has to be looked at (elsewhere it is far from zero).
    """
    counts = np.ceil((np.asarray(high) - low) / spacing).astype(int) + 1
    lines = [low[axis] + spacing * np.arange(counts[axis]) for axis in range(3)]
    flat = np.stack(np.meshgrid(*lines, indexing="ij"), -1).reshape(-1, 3)
    values = np.full(len(flat), 1.0)
    look = np.flatnonzero(_chunks(near, flat)) if near is not None else np.arange(len(flat))
    values[look] = _chunks(field, flat[look])
    values = values.reshape(counts)
    crossings = []
    for axis in range(3):
        begin = np.take(values, range(counts[axis] - 1), axis)
        edges = np.argwhere((begin < 0.0) != (np.take(values, range(1, counts[axis]), axis) < 0.0))
        first, second = values[tuple(edges.T)], values[tuple((edges + np.eye(3, dtype=int)[axis]).T)]
        crossings.append((edges, first / (first - second), first < 0.0))
    vertices, quads = nets(lines, crossings, spacing)
    return _relaxed(field, vertices, quads, spacing), quads


def _chunks(function, points):
    return np.concatenate([function(points[at : at + CHUNK]) for at in range(0, len(points), CHUNK)])


def _relaxed(field, vertices, quads, spacing):
    """Evenly spread over the surface: a step to the mean of the neighbours, a step back onto the zero, some rounds."""
    edges = np.unique(np.sort(np.concatenate([quads[:, [k, (k + 1) % 4]] for k in range(4)]), axis=1), axis=0)
    both = np.concatenate([edges, edges[:, ::-1]])
    degree = np.bincount(both[:, 0], minlength=len(vertices))[:, None]
    for _ in range(ROUNDS):
        total = np.stack([np.bincount(both[:, 0], vertices[both[:, 1], k], len(vertices)) for k in range(3)], 1)
        vertices = vertices + 0.5 * (total / degree - vertices)
        vertices = _projected(field, vertices, 0.1 * spacing)
    return _projected(field, vertices, 0.1 * spacing)


def _projected(field, vertices, step):
    """One step of Newton's method along the gradient."""
    slope = np.stack([field(vertices + step * axis) - field(vertices - step * axis) for axis in np.eye(3)], 1)
    slope /= 2.0 * step
    return vertices - (field(vertices) / np.maximum((slope**2).sum(1), 0.05))[:, None] * slope
