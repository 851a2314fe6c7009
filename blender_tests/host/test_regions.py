# SPDX-License-Identifier: GPL-3.0-or-later
"""Growing a region over a surface, and its soft border."""

import heapq

import meanvalue
import numpy as np
import pytest
from support import rings

from addon.posing.core.bind_input import BindInput, soft_border, spring_strengths

NO_FACES = np.empty((0, 3), np.int32)


@pytest.mark.parametrize("limit", [0.5, 2.0, 5.0])
def test_distances_are_those_of_dijkstra(limit):
    rng = np.random.default_rng(7)
    positions = rng.random((60, 3)).astype(np.float32) * 3.0
    edges = np.unique(np.sort(rng.integers(0, 60, (150, 2)), axis=1), axis=0).astype(np.int32)
    edges = edges[edges[:, 0] != edges[:, 1]]
    found = meanvalue.SurfaceWays(positions, edges, NO_FACES).distances([3], limit)
    along = np.array([dijkstra(edges, positions, 3).get(vertex, np.inf) for vertex in range(60)])
    expected = np.maximum(np.linalg.norm(positions - positions[3], axis=1), along / 2.0**0.5)
    assert np.allclose(found, np.where(expected <= limit, expected, np.inf))


def dijkstra(edges, positions, seed):
    positions = positions.astype(np.float64)
    shortest = {}
    queue = [(0.0, seed)]
    while queue:
        gone, vertex = heapq.heappop(queue)
        if vertex in shortest:
            continue
        shortest[vertex] = gone
        for first, second in edges.tolist():
            if vertex in (first, second):
                other = second if vertex == first else first
                heapq.heappush(queue, (gone + np.linalg.norm(positions[first] - positions[second]), other))
    return shortest


# Soft borders


def test_a_falloff_goes_down_without_a_kink():
    steps = np.linspace(0.0, 3.0, 301)
    line, edges = np.outer(steps, (1.0, 0.0, 0.0)), np.stack([np.arange(300), np.arange(1, 301)], axis=1)
    weights = meanvalue.SurfaceWays(line, edges, NO_FACES).falloff([0], 2.0, 0.5)
    assert (weights[steps <= 1.0] == 1.0).all() and (weights[steps >= 2.0] == 0.0).all()
    assert (np.diff(weights) <= 0.0).all() and weights[150] == pytest.approx(0.5)
    assert np.abs(np.diff(weights, 2)).max() < 1e-3
    weights = meanvalue.SurfaceWays(line, edges, NO_FACES).falloff([0], 1e-9)
    assert np.flatnonzero(weights).tolist() == [0, 1, 2], "the next edges follow"


def square_grid(rows):
    """(edges, positions) of squares of size 1."""
    number = np.arange(rows * rows).reshape(rows, rows)
    across = np.stack([number[:-1].ravel(), number[1:].ravel()], axis=1)
    along = np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], axis=1)
    positions = np.array([(x, y, 0.0) for x in range(rows) for y in range(rows)], np.float32)
    return np.concatenate([across, along]).astype(np.int32), positions


def distances(edges, positions, seeds, limit):
    return meanvalue.SurfaceWays(positions, edges, NO_FACES).distances(seeds, limit)


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


# Pieces, and limbs


def lathe(profile, columns=16):
    """(positions, triangles) of a shape of revolution: (radius, height) of each ring."""
    angles = np.linspace(0.0, 2.0 * np.pi, columns, endpoint=False)
    points = [(radius * np.cos(a), radius * np.sin(a), height) for radius, height in profile for a in angles]
    return np.array(points), rings.triangles(rings.quads(len(profile), columns))


def surface_ways(*pieces, gap=0.0):
    """(positions, SurfaceWays) of several (positions, triangles)."""
    firsts = np.cumsum([0, *(len(points) for points, _ in pieces)])
    points = np.concatenate([points for points, _ in pieces])
    triangles = np.concatenate([faces + first for (_, faces), first in zip(pieces, firsts, strict=False)])
    edges = np.unique(np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    return points, meanvalue.SurfaceWays(points, edges, triangles, gap=gap)


TUBE = [(0.2, height) for height in np.linspace(0.0, 3.0, 61)]


def test_layers_are_equally_far_and_what_is_only_near_in_space_is_not_reached():
    points, faces = lathe(TUBE)
    sleeve, _ = lathe([(0.21, height) for _, height in TUBE])
    found, ways = surface_ways((points, faces), (sleeve, faces), (np.add(points, (0.5, 0.0, 0.0)), faces), gap=0.02)
    for seed in (0, 30 * 16):
        skin, over, beside = ways.distances([seed], 1.0).reshape(3, -1)
        near = np.isfinite(skin)
        assert near.sum() > 100 and (near == np.isfinite(over)).all()
        assert np.abs(skin[near] - over[near]).max() < 0.02
        assert np.isinf(beside).all(), "the other limb is 0.1 away"
    assert np.unique(ways.parts).tolist() == [0, 976, 1952]
    assert (ways.distances([0], 9.0).reshape(3, -1)[1] == -1.0).all(), "a piece that is within it whole"
    assert np.isinf(meanvalue.SurfaceWays(found, [(0, 1)], NO_FACES).distances([0], 9.0)[2:]).all()


def test_a_beam_that_goes_through_another_touches_it_wherever_its_corners_are():
    upright = lathe([(0.1, 0.0), (0.1, 4.0)], 4)
    across = np.add(upright[0][:, [2, 1, 0]], (-1.7, 0.0, 1.6)), upright[1]
    _, ways = surface_ways(upright, across, gap=0.02)
    assert (ways.distances([0], 6.0)[8:] == -1.0).all()
    assert not np.isfinite(ways.distances([0], 1.4)[8:]).any(), "the way goes through where they meet"


@pytest.mark.parametrize("scale", [1.0, 1e-3, 1e4])
def test_a_limb_ends_at_the_body_and_a_ball_has_none(scale):
    body = [(0.1 + 0.9 * np.sin(turn), 2.0 + 0.9 * (1.0 - np.cos(turn))) for turn in np.linspace(0.0, np.pi, 40)]
    arm = [(0.1 * min(1.0, height / 0.1 + 0.05), height) for height in np.linspace(0.0, 2.0, 60)[:-1]]
    places, faces = lathe(arm + body, 24)
    points, ways = surface_ways((places * scale, faces))
    for height in (0.0, 0.5):
        pressed = int(np.abs(points[:, 2] / scale - height).argmin())
        assert ways.limb(pressed, 0.0, 4.0 * scale) == pytest.approx((2.0 - height) * scale, rel=0.2)
    sleeve = [(0.16 * scale, height * scale) for height in np.linspace(0.8, 1.8, 20)]
    _, dressed = surface_ways((points, faces), lathe(sleeve), gap=0.07 * scale)
    assert dressed.limb(0, 0.0, 4.0 * scale) == pytest.approx(2.0 * scale, rel=0.2), "a hem is no body"
    assert ways.limb(len(points) - 1, 0.0, 4.0 * scale) == 0.0
    assert ways.limb(0, 2.5 * scale, 4.0 * scale) == 0.0, "no limb is so long"
    _, ways = surface_ways(lathe([(np.sin(turn), -np.cos(turn)) for turn in np.linspace(0.05, 3.09, 40)], 24))
    assert all(ways.limb(vertex, 0.0, 3.0) == 0.0 for vertex in (0, 300, 500))
    edges, flat = square_grid(21)
    assert meanvalue.SurfaceWays(flat, edges, NO_FACES).limb(220, 0.0, 20.0) == 0.0


def test_ways_over_damaged_meshes_are_refused_or_end():
    points, faces = lathe(TUBE)
    broken = points.copy()
    broken[40] = np.nan, np.inf, 0.0
    _, ways = surface_ways((broken, faces), (points, faces), gap=0.02)
    assert np.isfinite(ways.distances([0], 0.5)).sum() > 50 and np.isfinite(ways.limb(0, 0.0, 3.0))
    point = meanvalue.SurfaceWays(np.zeros((3, 3)), [(0, 1), (1, 2)], NO_FACES)
    assert point.limb(0, 0.0, 0.0) == 0.0 and point.falloff([0], 0.0).tolist() == [1.0, 1.0, 1.0]
    beside, weights, _ = meanvalue.Surface(points, faces).nearest([[np.nan, 0.0, 0.0], [1e200, 0.0, 0.0]])
    assert beside.tolist() == [-1, -1] and not weights.any()
    for edges, triangles, seeds in ([[(0, 976)], faces, [0]], [[(0, 1)], faces + 1, [0]], [[(0, 1)], faces, [-1]]):
        with pytest.raises(meanvalue.InvalidInput, match="vertices"):
            meanvalue.SurfaceWays(points, edges, triangles).distances(seeds, 1.0)


def test_springs_are_shared_out_among_what_may_move_in_one_piece():
    """What may move elsewhere does not matter: a press on another limb would move what is posed."""

    def springs(rows, *free):
        points, number = np.indices((rows, 40)).reshape(2, -1).T, np.arange(40 * rows).reshape(rows, 40)
        quads = np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], -1).reshape(-1, 4)
        weights = np.isin(points[:, 1], [column for columns in free for column in columns]) * 0.5
        faces = quads.ravel().astype(np.int32), np.arange(0, quads.size, 4, dtype=np.int32)
        anchors, held = np.array([5], np.int32), np.zeros(1, np.int32)
        soft = {"strengths": spring_strengths(held, [0.5], 15.0)}
        soft["border"], soft["border_strengths"] = soft_border(weights, anchors, 15.0)
        whole = BindInput(np.float32(points), *faces, anchors, weights > 0.0, "fast", held, 15.0, **soft).solver_mesh
        return whole.strengths[0], whole.border_strengths[0]

    alone = springs(4, range(10))
    assert springs(4, range(10), range(12, 40)) == alone
    assert np.allclose(springs(8, range(10)), np.array(alone) / (2.0, 4.0))


def disk(rows, strength=None):
    """(Deformer, targets at rest, handle's rows of them) of a flat grid whose middle is a handle, free within 0.8.

    strength: scales the springs by which the rest is held, fading out from the handle; None: a region of yes and no.
    """
    line = np.linspace(-1.0, 1.0, rows)
    points = np.array([(x, y, 0.0) for x in line for y in line])
    number = np.arange(rows * rows).reshape(rows, rows)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    away = np.linalg.norm(points, axis=1)
    edges = np.concatenate([quads[:, :2], quads[:, 1:3], quads[:, 2:], quads[:, [3, 0]]])
    weights = meanvalue.SurfaceWays(points, edges, NO_FACES).falloff([rows * rows // 2], 0.8, 0.125)
    handle = np.flatnonzero(away <= 0.1)
    border, held = soft_border(weights, handle, 15.0) if strength else (np.empty(0, np.int32), np.empty(0))
    held = held / np.count_nonzero(weights) ** 2
    anchors = np.concatenate([handle, border]).astype(np.int32)
    deformer = meanvalue.Deformer(
        points,
        rings.triangles(quads),
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
