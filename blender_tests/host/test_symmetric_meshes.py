# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh that is symmetric by itself: which vertices are twins, and what handles of both sides agree on."""

import numpy as np
from support.mirrored_bodies import body

from addon.scene.core import whole_mesh
from blender_tests.host.test_mirroring import faces, symmetric


def shuffled(vertices, triangles, seed=3):
    order = np.random.default_rng(seed).permutation(len(vertices))
    new = np.argsort(order)
    return vertices[order], new[triangles].astype(np.int32)


def test_twins_in_a_mesh_that_is_nearly_symmetric():
    vertices, triangles = shuffled(*body())
    size = np.linalg.norm(np.ptp(vertices, axis=0))
    noise = np.random.default_rng(1).uniform(-1.0, 1.0, vertices.shape) * 2e-4 * size
    shapes = (vertices + noise).astype(np.float32), vertices.astype(np.float32)
    found, exact = (whole_mesh.partners(each, *faces(triangles), (1.0, 0.0, 0.0, 0.0)) for each in shapes)
    assert np.abs(vertices[exact] * (-1.0, 1.0, 1.0) - vertices).max() < 1e-6 and np.array_equal(found, exact)


def test_twins_of_split_edges_follow_the_faces():
    vertices, triangles = body()
    own = vertices[triangles].reshape(-1, 3)  # every triangle has corners of its own
    split = np.arange(len(own), dtype=np.int32).reshape(-1, 3)
    found = whole_mesh.partners(own.astype(np.float32), *faces(split), (1.0, 0.0, 0.0, 0.0))
    assert (found >= 0).all()
    images = np.sort(found[split], axis=1)
    assert len(np.unique(images // 3)) == len(split) and (images // 3 == images[:, :1] // 3).all()


def test_what_has_no_twin_is_told():
    vertices, triangles = body()
    away = np.argmax(vertices[:, 0])
    vertices[away] += [0.0, 0.0, 0.05]
    found = whole_mesh.partners(vertices.astype(np.float32), *faces(triangles), (1.0, 0.0, 0.0, 0.0))
    assert np.count_nonzero(found < 0) == 2 and found[away] == -1


def test_of_two_handles_on_mirrored_places_the_upper_one_leads():
    vertices, triangles = body()
    right, left = np.flatnonzero(vertices[:, 0] > 0.7), np.flatnonzero(vertices[:, 0] < -0.7)
    given = symmetric(vertices, triangles, [np.flatnonzero(vertices[:, 2] < -1.5), right, left])
    positions = given.anchor_rest.copy()
    positions[given.handles == 1] += [0.3, 0.0, 0.2]
    positions[given.handles == 2] += [0.0, 0.7, 0.0]
    met = given.solver_mesh.met(positions) - given.anchor_rest
    assert np.allclose(met[given.handles == 1], [0.3, 0.0, 0.2])
    assert np.allclose(met[given.handles == 2], [-0.3, 0.0, 0.2])


def test_a_handle_on_both_sides_does_what_both_sides_agree_on():
    vertices, triangles = body()
    given = symmetric(
        vertices, triangles, [np.flatnonzero(vertices[:, 2] < -1.5), np.flatnonzero(vertices[:, 2] > 1.5)]
    )
    positions = given.anchor_rest.copy()
    positions[given.handles == 1] += [0.3, 0.1, 0.2]
    met = given.solver_mesh.met(positions) - given.anchor_rest
    assert np.allclose(met[given.handles == 1], [0.0, 0.1, 0.2])


def test_where_a_handle_holds_the_other_side_of_a_soft_border():
    vertices, triangles = body()
    freedom = np.where(vertices[:, 0] < 0.0, 0.5, 1.0)
    right = np.flatnonzero(vertices[:, 0] > 0.7)
    given = symmetric(vertices, triangles, [np.flatnonzero(vertices[:, 2] < -1.5), right], freedom=freedom)
    assert np.isin(given.twins[0][right], given.border).any()
    assert not np.isin(given.twins[0][right], given.solver_mesh.border).any()


def test_many_vertices_in_one_place_beside_pairs_that_are_found():
    random = np.random.default_rng(5)
    pairs = random.uniform(0.5, 2.0, (50, 3))
    crowds = [np.array((side, 1.0, 1.0)) + 1e-4 * random.standard_normal((2_000, 3)) for side in (1.0, -1.0)]
    points = np.concatenate([pairs, pairs * (-1.0, 1.0, 1.0), *crowds])
    corners, starts = np.empty(0, np.int32), np.empty(0, np.int32)
    found = whole_mesh.partners(points.astype(np.float32), corners, starts, (1.0, 0.0, 0.0, 0.0))
    assert np.array_equal(found[:100], np.roll(np.arange(100), 50))
    paired = np.flatnonzero(found >= 0)
    assert np.array_equal(found[found[paired]], paired)
