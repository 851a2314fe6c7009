# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a scalar field is zero, as a mesh of quads: surface nets (Gibson 1998). Needs numpy alone."""

import numpy as np

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
    vertices, number = _vertices(values, low, spacing)
    quads = _quads(values, number)
    return _relaxed(field, vertices, quads, spacing), quads


def _chunks(function, points):
    return np.concatenate([function(points[at : at + CHUNK]) for at in range(0, len(points), CHUNK)])


def _vertices(values, low, spacing):
    """One vertex in each cell that the surface crosses: the mean of where it crosses the cell's edges."""
    shape = np.array(values.shape) - 1
    total, crossings = np.zeros((*shape, 3)), np.zeros(shape)
    corners = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), -1)
    for axis in range(3):
        for a in (0, 1):
            for b in (0, 1):
                at = np.insert([a, b], axis, 0)
                begin = values[tuple(slice(at[k], at[k] + shape[k]) for k in range(3))]
                at[axis] = 1
                end = values[tuple(slice(at[k], at[k] + shape[k]) for k in range(3))]
                cut = (begin < 0.0) != (end < 0.0)
                place = np.broadcast_to(np.insert([a, b], axis, 0), (*shape, 3)).astype(float).copy()
                place[..., axis] = np.where(cut, begin / np.where(cut, begin - end, 1.0), 0.0)
                total += np.where(cut[..., None], corners + place, 0.0)
                crossings += cut
    here = crossings > 0
    number = np.full(shape, -1)
    number[here] = np.arange(here.sum())
    return low + spacing * total[here] / crossings[here][:, None], number


def _quads(values, number):
    """A quad around each edge of the grid that the surface crosses."""
    quads = []
    for axis in range(3):
        others = [(axis + 1) % 3, (axis + 2) % 3]
        begin = np.take(values, range(values.shape[axis] - 1), axis) < 0.0
        end = np.take(values, range(1, values.shape[axis]), axis) < 0.0
        at = np.argwhere(begin != end)
        steps = np.zeros((4, 3), int)
        steps[[1, 2], others[0]] = -1
        steps[[2, 3], others[1]] = -1
        ring = number[tuple((at[:, None] + steps).transpose(2, 0, 1))]
        leaves = begin[tuple(at.T)]
        quads.append(np.where(leaves[:, None], ring[:, [2, 3, 0, 1]], ring[:, ::-1]))
    return np.concatenate(quads)


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
