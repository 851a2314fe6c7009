# SPDX-License-Identifier: GPL-3.0-or-later
"""Growing a region over a surface, its soft border, and which faces it tints."""

import heapq

import meanvalue
import numpy as np
import pytest

from addon.posing.core import springs
from addon.posing.core.bind_input import soft_border
from addon.posing.core.region_growth import distances, falloff, nearness, parts_within
from addon.posing.core.tinted_faces import tinted_faces

CHAIN = np.array([(0, 1), (1, 2), (2, 3), (3, 4), (5, 6)], np.int32)
CHAIN_POSITIONS = np.array([(0, 0, 0), (1, 0, 0), (3, 0, 0), (6, 0, 0), (10, 0, 0), (0, 1, 0), (1, 1, 0)], np.float32)


def chosen(mask):
    return np.flatnonzero(mask).tolist()


@pytest.mark.parametrize(
    "seeds, distance, expected",
    [([0], 1.2, []), ([0], 1.5, [5, 6]), ([0, 2], 0.2, []), ([0, 2], 1.0, [5, 6]), ([5], 9.0, []),
     ([5], 10.1, [0, 1, 2, 3, 4]), ([1, 6], 99.0, [])],
)  # fmt: skip
def test_whole_parts_that_are_near_in_space(seeds, distance, expected):
    assert chosen(parts_within(CHAIN, CHAIN_POSITIONS, np.array(seeds), distance)) == expected


def test_parts_are_found_in_whatever_order_their_edges_come():
    numbers = np.random.default_rng(3)
    chain = np.stack([np.arange(400), np.arange(1, 401)], axis=1)
    order = numbers.permutation(403)
    positions = np.full((403, 3), 0.5, np.float32)
    positions[order[200]] = 9.0
    edges = order[np.concatenate([numbers.permutation(chain), [(401, 402)]])]
    near = parts_within(edges, positions, order[402:], 1.0)
    assert not near.any(), "one vertex of the chain is far"
    near = parts_within(edges, positions, order[402:], 99.0)
    assert chosen(~near) == sorted(order[401:].tolist())


@pytest.mark.parametrize("limit", [0.5, 2.0, 5.0])
def test_distances_are_those_of_dijkstra(limit):
    rng = np.random.default_rng(7)
    positions = rng.random((60, 3)).astype(np.float32) * 3.0
    edges = np.unique(np.sort(rng.integers(0, 60, (150, 2)), axis=1), axis=0).astype(np.int32)
    edges = edges[edges[:, 0] != edges[:, 1]]
    lengths = np.linalg.norm(positions[edges[:, 0]].astype(np.float64) - positions[edges[:, 1]], axis=1)
    found, _origins = nearness(edges, lengths, np.array([3, 9]), len(positions), limit)
    assert chosen(found <= limit) == dijkstra(edges, positions, [3, 9], limit)


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


# Soft borders


def test_a_falloff_goes_down_without_a_kink():
    steps = np.linspace(0.0, 3.0, 301)
    weights = falloff(steps, 1.0, 2.0)
    assert (weights[steps <= 1.0] == 1.0).all() and (weights[steps >= 2.0] == 0.0).all()
    assert (np.diff(weights) <= 0.0).all() and weights[150] == pytest.approx(0.5)
    assert np.abs(np.diff(weights, 2)).max() < 1e-3
    assert falloff(np.array([np.inf]), 1.0, 2.0)[0] == 0.0


def square_grid(rows):
    """(edges, positions) of squares of size 1."""
    number = np.arange(rows * rows).reshape(rows, rows)
    across = np.stack([number[:-1].ravel(), number[1:].ravel()], axis=1)
    along = np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], axis=1)
    positions = np.array([(x, y, 0.0) for x in range(rows) for y in range(rows)], np.float32)
    return np.concatenate([across, along]).astype(np.int32), positions


def test_what_is_equally_far_on_a_flat_grid_lies_on_a_circle():
    edges, positions = square_grid(21)
    found = distances(edges, positions, np.array([220]), 7.0)
    straight = np.linalg.norm(positions - positions[220], axis=1)
    assert np.allclose(found, np.where(straight <= 7.0, straight, np.inf))


def test_what_is_folded_back_is_not_near():
    edges, positions = square_grid(21)
    right = positions[:, 0] > 10.0
    positions[right, 0], positions[right, 2] = 20.0 - positions[right, 0], 0.1
    found = distances(edges, positions, np.array([220 - 5 * 21]), 10.0)
    assert found[220 + 5 * 21] > 7.0


def test_only_weights_between_none_and_all_are_a_border():
    border, strengths = soft_border(np.array([0.0, 0.5, 1.0, 0.25, 0.5]), np.array([4]), 15.0)
    assert border.tolist() == [1, 3]
    assert strengths[1] == pytest.approx(3.0 * strengths[0])
    assert soft_border(np.array([0.0, 1.0, 1.0]), np.array([1]), 15.0) == (None, None)


def test_a_finer_mesh_has_weaker_springs_by_the_square_of_its_vertices():
    coarse, fine = (springs.border_strengths(np.array([0.5]), 15.0, count)[0] for count in (100, 400))
    assert coarse == pytest.approx(16.0 * fine)


def disk(rows, strength=None):
    """(Deformer, targets at rest, handle's rows of them) of a flat grid whose middle is a handle, free within 0.8.

    strength: scales the springs by which the rest is held, fading out from the handle; None: a region of yes and no.
    """
    line = np.linspace(-1.0, 1.0, rows)
    points = np.array([(x, y, 0.0) for x in line for y in line])
    number = np.arange(rows * rows).reshape(rows, rows)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]).astype(np.int32)
    away = np.linalg.norm(points, axis=1)
    weights = falloff(away, 0.1, 0.8)
    handle = np.flatnonzero(away <= 0.1)
    border, held = soft_border(weights, handle, 15.0) if strength else (np.empty(0, np.int32), np.empty(0))
    anchors = np.concatenate([handle, border]).astype(np.int32)
    deformer = meanvalue.Deformer(
        points,
        triangles,
        anchors,
        roi=weights > 0.0,
        handles=np.repeat([0, 1], [len(handle), len(border)]).astype(np.int32),
        rigidity=15.0,
        strengths=np.concatenate([np.full(len(handle), np.inf), (strength or 1.0) * held]),
    )
    return deformer, points, weights, anchors, len(handle)


def lifted(made, height, start=None):
    deformer, points, _weights, anchors, handle_size = made
    targets = points[anchors].copy()
    targets[:handle_size, 2] += height
    return deformer.solve(targets, start=start)


def test_the_border_follows_alike_on_meshes_of_any_resolution():
    shares = []
    for rows in (31, 61):
        made = disk(rows, 1.0)
        heights = lifted(made, 0.2).vertices[:, 2] / 0.2
        shares.append(heights[np.abs(made[2] - 0.5) < 0.1].mean())
    assert abs(shares[0] - shares[1]) < 0.05, shares
    assert 0.3 < shares[0] < 0.6


def test_the_surface_is_smooth_where_the_region_ends():
    """The turn of the surface from edge to edge is nowhere at the border sharper than around the handle."""
    made = disk(61, 1.0)
    heights = lifted(made, 0.2).vertices[:, 2].reshape(61, 61)[30]
    turns = np.abs(np.diff(heights, 2))
    away = np.abs(np.linspace(-1.0, 1.0, 61)[1:-1])
    assert turns[away > 0.7].max() < 0.25 * turns[away < 0.4].max()
