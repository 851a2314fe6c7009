# SPDX-License-Identifier: GPL-3.0-or-later
"""Regions that grow over the surface from some vertices, along edges."""

import numpy as np


def grown_by_rings(edges, seeds, vertex_count, ring_count):
    """n bool: vertices that can be reached from `seeds` over at most `ring_count` edges; seeds are among them.

    edges  m x 2 vertex indices.
    """
    return _nearness(edges, np.ones(len(edges)), seeds, vertex_count, ring_count) <= ring_count


def grown_by_distance(edges, positions, seeds, distance):
    """n bool: vertices within `distance` of `seeds`, measured along edges; seeds are among them.

    edges  m x 2 vertex indices; positions  n x 3. A way along edges is at least as long as one straight over the faces,
    by up to two fifths on a grid of squares.
    """
    lengths = np.linalg.norm(positions[edges[:, 0]].astype(np.float64) - positions[edges[:, 1]], axis=1)
    return _nearness(edges, lengths, seeds, len(positions), distance) <= distance


def _nearness(edges, lengths, seeds, vertex_count, limit):
    """n float64: length of the shortest way from the seeds; infinite beyond `limit`.

    Shortest paths after Bellman and Ford, going on only from the vertices that came nearer in the last step: a few
    numpy calls for each ring, where a queue (Dijkstra) takes several Python steps for each edge.
    """
    starts, neighbours, lengths = _ways(edges, lengths, vertex_count)
    nearness = np.full(vertex_count, np.inf)
    nearness[seeds] = 0.0
    front = np.unique(seeds)
    while len(front):
        counts = starts[front + 1] - starts[front]
        first_of_each = np.cumsum(counts) - counts
        ways = np.arange(counts.sum()) + np.repeat(starts[front] - first_of_each, counts)
        others, found = neighbours[ways], np.repeat(nearness[front], counts) + lengths[ways]
        is_nearer = (found < nearness[others]) & (found <= limit)
        np.minimum.at(nearness, others[is_nearer], found[is_nearer])
        front = np.unique(others[is_nearer])
    return nearness


def _ways(edges, lengths, vertex_count):
    """(starts, neighbours, lengths) as arrays: the ways from vertex v are starts[v] to starts[v + 1]."""
    origins = np.concatenate([edges[:, 0], edges[:, 1]])
    order = np.argsort(origins, kind="stable")
    starts = np.concatenate([[0], np.cumsum(np.bincount(origins, minlength=vertex_count))])
    neighbours = np.concatenate([edges[:, 1], edges[:, 0]])
    return starts, neighbours[order], np.tile(lengths, 2)[order]
