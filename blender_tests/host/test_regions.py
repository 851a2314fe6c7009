# SPDX-License-Identifier: GPL-3.0-or-later
"""Growing a region over a surface, and which faces it tints."""

import heapq

import numpy as np
import pytest

from addon.core.region_growth import grown_by_distance, grown_by_rings
from addon.core.tinted_faces import tinted_faces

CHAIN = np.array([(0, 1), (1, 2), (2, 3), (3, 4), (5, 6)], np.int32)
CHAIN_POSITIONS = np.array([(0, 0, 0), (1, 0, 0), (3, 0, 0), (6, 0, 0), (10, 0, 0), (0, 1, 0), (1, 1, 0)], np.float32)


def chosen(mask):
    return np.flatnonzero(mask).tolist()


@pytest.mark.parametrize(
    "seeds, rings, expected",
    [([2], 0, [2]), ([2], 1, [1, 2, 3]), ([0], 2, [0, 1, 2]), ([0, 4], 1, [0, 1, 3, 4]), ([0], 99, [0, 1, 2, 3, 4])],
)
def test_rings(seeds, rings, expected):
    assert chosen(grown_by_rings(CHAIN, np.array(seeds), 7, rings)) == expected


@pytest.mark.parametrize(
    "seeds, distance, expected",
    [([0], 0.0, [0]), ([0], 2.9, [0, 1]), ([0], 3.0, [0, 1, 2]), ([3], 3.0, [2, 3]), ([0], 1e9, [0, 1, 2, 3, 4])],
)
def test_distance(seeds, distance, expected):
    assert chosen(grown_by_distance(CHAIN, CHAIN_POSITIONS, np.array(seeds), distance)) == expected


def test_what_is_near_in_space_but_not_on_the_surface_is_left_out():
    assert 5 not in chosen(grown_by_distance(CHAIN, CHAIN_POSITIONS, np.array([0]), 100.0))


def test_without_edges_only_the_seeds():
    none = np.empty((0, 2), np.int32)
    assert chosen(grown_by_rings(none, np.array([1]), 3, 5)) == [1]
    assert chosen(grown_by_distance(none, np.zeros((3, 3), np.float32), np.array([1]), 5.0)) == [1]


def test_edges_without_length_cost_nothing():
    edges = np.array([(0, 1), (1, 0), (1, 2)], np.int32)
    assert chosen(grown_by_distance(edges, np.zeros((3, 3), np.float32), np.array([0]), 0.0)) == [0, 1, 2]


@pytest.mark.parametrize("limit", [0.5, 2.0, 5.0])
def test_distances_are_those_of_dijkstra(limit):
    rng = np.random.default_rng(7)
    positions = rng.random((60, 3)).astype(np.float32) * 3.0
    edges = np.unique(np.sort(rng.integers(0, 60, (150, 2)), axis=1), axis=0).astype(np.int32)
    edges = edges[edges[:, 0] != edges[:, 1]]
    assert chosen(grown_by_distance(edges, positions, np.array([3, 9]), limit)) == dijkstra(
        edges, positions, [3, 9], limit
    )


def dijkstra(edges, positions, seeds, limit):
    positions = positions.astype(np.float64)
    shortest = {}
    queue = [(0.0, seed) for seed in seeds]
    while queue:
        gone, vertex = heapq.heappop(queue)
        if gone > limit or vertex in shortest:
            continue
        shortest[vertex] = gone
        for first, second in edges.tolist():
            if vertex in (first, second):
                other = second if vertex == first else first
                heapq.heappush(queue, (gone + np.linalg.norm(positions[first] - positions[second]), other))
    return sorted(shortest)


def test_only_faces_that_lie_wholly_in_the_region_are_tinted():
    # a quad 0 1 2 3, a pentagon 1 4 5 6 2, a triangle 3 2 7
    corners = np.array([0, 1, 2, 3, 1, 4, 5, 6, 2, 3, 2, 7], np.int32)
    starts = np.array([0, 4, 9], np.int32)
    triangles = np.array([(0, 1, 2), (0, 2, 3), (1, 4, 5), (1, 5, 6), (1, 6, 2), (3, 2, 7)], np.int32)
    region = np.ones(8, bool)
    region[7] = False
    vertices, tinted = tinted_faces(triangles, corners, starts, region)
    assert vertices[tinted].tolist() == triangles[:5].tolist()
    region[0] = False
    vertices, tinted = tinted_faces(triangles, corners, starts, region)
    assert vertices.tolist() == [1, 2, 4, 5, 6]
    assert vertices[tinted].tolist() == triangles[2:5].tolist()


def test_nothing_is_tinted_without_faces_or_region():
    none = np.empty(0, np.int32)
    vertices, tinted = tinted_faces(np.empty((0, 3), np.int32), none, none, np.ones(3, bool))
    assert len(vertices) == len(tinted) == 0
    triangle = np.array([(0, 1, 2)], np.int32)
    vertices, tinted = tinted_faces(triangle, triangle[0], np.array([0], np.int32), np.zeros(3, bool))
    assert (len(vertices), tinted.shape) == (0, (0, 3))
