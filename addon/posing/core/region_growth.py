# SPDX-License-Identifier: GPL-3.0-or-later
"""Regions that grow over the surface from some vertices, along edges."""

import numpy as np

from ...scene.core import connected

#: How much longer than straight over the faces a way along edges is on a grid of squares.
MOST_DETOUR = 2.0**0.5


def distances(edges, positions, seeds, limit):
    """n float64: about how far each vertex is from `seeds` over the surface; infinite beyond `limit`.

    Straight to the seed that is nearest along edges, so that what is equally far lies on a circle where the surface is
    flat, whatever its faces are; but no less than what the way along edges says, which is longer than one over the
    faces by up to sqrt(2) on a grid of squares: what is folded back to the seeds is not near.

    edges  m x 2 vertex indices; positions  n x 3.
    """
    near = _may_be_within(positions, seeds, MOST_DETOUR * limit)
    edges = edges[near[edges].all(axis=1)]
    lengths = np.linalg.norm(positions[edges[:, 0]].astype(np.float64) - positions[edges[:, 1]], axis=1)
    along, nearest = nearness(edges, lengths, seeds, len(positions), MOST_DETOUR * limit)
    reached = np.flatnonzero(np.isfinite(along))
    straight = np.linalg.norm(positions[reached].astype(np.float64) - positions[nearest[reached]], axis=1)
    result = np.full(len(positions), np.inf)
    result[reached] = np.maximum(straight, along[reached] / MOST_DETOUR)
    result[result > limit] = np.inf
    return result


def parts_within(edges, positions, seeds, limit):
    """n bool: connected parts without a seed, such as eyes, that lie whole within `limit` of the ball around
    the seeds, straight through space."""
    centre = positions[seeds].mean(axis=0, dtype=np.float64)
    apart = np.linalg.norm(positions - centre, axis=1)
    is_out = apart > apart[seeds].max() + limit
    is_out[seeds] = True
    parts = connected.parts(edges, len(positions))
    is_whole = np.ones(len(positions), bool)
    is_whole[parts[is_out]] = False
    return is_whole[parts]


def falloff(distances, inner, outer):
    """Weights from 0 to 1: 1 up to the distance `inner`, 0 from `outer` on, smooth between, as Proportional Editing's.

    It is 3 t^2 - 2 t^3, t from 1 to 0, so that it has no kink at either end.
    """
    t = np.clip((outer - distances) / (outer - inner), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def _may_be_within(positions, seeds, limit):
    """n bool: whether a vertex is near enough to the box around the seeds, straight through space."""
    low, high = positions[seeds].min(axis=0) - limit, positions[seeds].max(axis=0) + limit
    return ((positions >= low) & (positions <= high)).all(axis=1)


def nearness(edges, lengths, seeds, vertex_count, limit):
    """(n float64, n int): length of the shortest way from the seeds, infinite beyond `limit`; the seed it is from.

    Shortest paths after Bellman and Ford, going on only from the vertices that came nearer in the last step: a few
    numpy calls for each ring, where a queue (Dijkstra) takes several Python steps for each edge.
    """
    starts, neighbours, lengths = _ways(edges, lengths, vertex_count)
    nearness = np.full(vertex_count, np.inf)
    nearness[seeds] = 0.0
    origins = np.arange(vertex_count)
    front = np.unique(seeds)
    while len(front):
        counts = starts[front + 1] - starts[front]
        first_of_each = np.cumsum(counts) - counts
        ways = np.arange(counts.sum()) + np.repeat(starts[front] - first_of_each, counts)
        others, found = neighbours[ways], np.repeat(nearness[front], counts) + lengths[ways]
        by_vertex = np.lexsort((found, others))
        others, shortest = np.unique(others[by_vertex], return_index=True)
        best = by_vertex[shortest]
        is_nearer = (found[best] < nearness[others]) & (found[best] <= limit)
        best, others = best[is_nearer], others[is_nearer]
        nearness[others] = found[best]
        origins[others] = np.repeat(origins[front], counts)[best]
        front = others
    return nearness, origins


def _ways(edges, lengths, vertex_count):
    """(starts, neighbours, lengths) as arrays: the ways from vertex v are starts[v] to starts[v + 1]."""
    origins = np.concatenate([edges[:, 0], edges[:, 1]])
    order = np.argsort(origins, kind="stable")
    starts = np.concatenate([[0], np.cumsum(np.bincount(origins, minlength=vertex_count))])
    neighbours = np.concatenate([edges[:, 1], edges[:, 0]])
    return starts, neighbours[order], np.tile(lengths, 2)[order]
