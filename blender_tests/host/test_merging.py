# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertices in one place, merged for the solve only."""

import numpy as np
import pytest

from addon.errors import SceneError
from addon.scene.core.welding import first_of_place, require_no_more_than_seams, together
from blender_tests.host.test_messy_meshes import bent_tube, given, solved, tube


def cut_open(seed=0):
    """A tube all of whose triangles have corners of their own, up to 1e-4 apart; and which vertex each was."""
    vertices, triangles = tube()
    numbers = triangles.ravel()
    jitter = np.random.default_rng(seed).uniform(-5e-5, 5e-5, (len(numbers), 3))
    return vertices[numbers] + jitter, np.arange(len(numbers), dtype=np.int32).reshape(-1, 3), numbers


def test_a_copy_that_is_fixed_fixes_all_and_hard_handles_lead():
    split, own, numbers = cut_open()
    roi = np.ones(len(split), bool)
    free = np.flatnonzero(numbers == 60)
    roi[free[0]] = False
    handles = np.flatnonzero(numbers == 90)
    bind_input = given(
        split,
        own,
        np.sort(handles[:2]),
        [0, 1],
        roi=roi,
        strengths=np.array([0.5, np.inf]),
        stiffness=1.0 + np.arange(len(split)),
        merge_distance=3e-4,
    )
    whole = bind_input.solver_mesh
    assert not whole.roi[whole.places[free]].any()
    assert whole.anchors.tolist() == [whole.places[handles[0]]]
    assert np.isinf(whole.strengths).all()
    pair = np.flatnonzero(whole.places == whole.places[handles[0]])
    assert whole.stiffness[whole.places[pair[0]]] == 1.0 + pair.mean()
    targets = bind_input.anchor_rest + np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    assert np.allclose(whole.met(targets) - bind_input.anchor_rest, [0.0, 0.0, 1.0], atol=1e-6)


def test_what_is_apart_in_another_shape_stays_apart():
    """Lips: two upper copies go one way, two lower ones another."""
    rest = np.repeat(np.eye(3, dtype=np.float32), 4, axis=0)
    opened = rest.copy()
    opened[[1, 3], 2] += 0.1
    first = np.repeat([0, 4, 8], 4)
    assert together(first, [rest, opened], 0.0).tolist() == [0, 1, 0, 1, *[4] * 4, *[8] * 4]
    assert together(first, [rest, opened], 0.2).tolist() == first.tolist()


@pytest.mark.parametrize("is_turned", [False, True])
def test_open_borders_in_one_place_are_one_and_so_are_doubles_and_other_layers_are_not(is_turned):
    vertices, triangles = tube()
    expected, _ = bent_tube(vertices, triangles, 192)
    inner = triangles[(triangles < 96).all(axis=1), :: -1 if is_turned else 1]  # shorter
    both, numbers = np.concatenate([inner, triangles + 96]), np.r_[:96, :192]
    layers, anchors, moves = vertices[numbers], np.r_[96:108, 276:288], (expected - vertices)[numbers]
    bind_input = given(layers, both, anchors, np.repeat([0, 1], 12), close_seams=True)
    result, _ = solved(bind_input, both, bind_input.anchor_rest + moves[anchors])
    assert np.abs(result - bind_input.rest - moves).max() < 1e-3 and bind_input.joined_places == 96
    layers[50, 0] += 0.01  # no double
    assert given(layers, both, anchors, close_seams=True).joined_places == 24  # its ends, one of them inside
    assert given(vertices, triangles, np.arange(12), close_seams=True).copies is None


def refuse(vertices, triangles, distance):
    starts = np.arange(0, triangles.size, 3)
    require_no_more_than_seams(vertices.astype(np.float32), triangles.ravel(), starts, distance)


@pytest.mark.parametrize("share", [0.004, 0.009])
def test_a_merge_distance_longer_than_edges_is_refused_and_one_that_does_is_named(share):
    side = 200
    numbers = np.arange(side * side).reshape(side, side)
    vertices = np.stack([numbers % side, numbers // side, 0.0 * numbers], axis=2).reshape(-1, 3) / (side * 2.0**0.5)
    one, two, three, four = numbers[:-1, :-1], numbers[:-1, 1:], numbers[1:, 1:], numbers[1:, :-1]
    triangles = np.stack([one, two, three, one, three, four], axis=2).reshape(-1, 3).astype(np.int32)
    # an open seam, which is closed with what is named
    vertices = np.concatenate([vertices, vertices[side // 2 :: side] + 1e-5])
    told = r"Merge Distance 0\.00\d would merge \d+\.\d% .* Choose \S+ or less"
    with pytest.raises(SceneError, match=told) as refused:
        refuse(vertices, triangles, share)
    named = float(str(refused.value).split("Choose ")[1].split()[0])
    assert 1e-3 <= named < 1.0 / side
    refuse(vertices, triangles, named)
    assert len(given(vertices, triangles, np.arange(side), merge_distance=named).solver_mesh.rest) == side * side


def joined_by_comparing_all(points, distance):
    is_near = ((points[:, None] - points[None]) ** 2).sum(axis=2) <= distance**2
    first = np.arange(len(points))
    while True:
        lowest = np.where(is_near, first[None], len(points)).min(axis=1)
        if np.array_equal(lowest, first):
            return first
        first = lowest


@pytest.mark.parametrize("distance", [1e-9, 0.01, 0.04, 0.08, 0.3, 3.0])
@pytest.mark.parametrize("offset", [0.0, 1e4])
def test_points_in_one_place_are_those_that_comparing_all_finds(distance, offset):
    random = np.random.default_rng(7)
    piles = np.repeat(random.random((20, 3)), 20, axis=0)
    points = np.concatenate([random.random((500, 3)), piles, piles + random.uniform(-0.01, 0.01, piles.shape)]) + offset
    assert np.array_equal(first_of_place(points, distance), joined_by_comparing_all(points, distance))


def test_many_points_in_one_place_cost_no_more_than_others():
    """All pairs of them would not fit into memory."""
    random = np.random.default_rng(8)
    pile = np.zeros((100_000, 3))
    jittered = random.uniform(-0.1, 0.1, (20_000, 3)) * 1e-3
    beside = np.array([1.05e-3, 0.0, 0.0])  # in the cells around, out of reach for most
    points = np.concatenate([pile + 5.0, jittered, jittered + beside, random.random((1000, 3)) + 10.0])
    first = first_of_place(points, 1e-3)
    assert (first[:100_000] == 0).all()
    assert (first[100_000:140_000] == 100_000).all()
    first = first_of_place(points, 0.7e-3)
    assert (first[100_000:120_000] == 100_000).all() and (first[120_000:140_000] == 120_000).all()
    assert len(np.unique(first[140_000:])) == 1000
