# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/posing/core/solver_mesh.py: a part of a body, solved with its images, is the body solved as a whole."""

import numpy as np
import pytest
from support import native_calls
from support.mirrored_bodies import body, part

from addon.errors import SceneError
from addon.posing.core.bind_input import soft_border, spring_strengths
from addon.scene.core import motion, whole_mesh
from blender_tests.host.test_messy_meshes import given as bind_input_of
from native.benchmarks.rigid import rotation_about
from native.benchmarks.shape_metrics import volume

AXES = [(0,), (1,), (2,), (0, 1), (0, 2), (0, 1, 2)]


def unit(axis):
    return np.eye(3)[axis]


def rows(axes):
    return np.array([(*unit(axis), 0.0) for axis in axes])


def faces(triangles):
    return triangles.ravel().astype(np.int32), np.arange(0, triangles.size, 3, dtype=np.int32)


def bind_input(vertices, triangles, groups, planes=None, joined=None, soft=None, roi=None, freedom=None):
    """groups: lists of vertex numbers; freedom: n weights of a soft region, or None."""
    anchors = np.sort(np.concatenate(groups)).astype(np.int32)
    pieces = np.array([next(n for n, group in enumerate(groups) if each in group) for each in anchors], np.int32)
    roi = np.ones(len(vertices), bool) if roi is None else roi
    border, border_strengths = (None, None) if freedom is None else soft_border(freedom, anchors, 10.0)
    strengths = spring_strengths(pieces, soft or [None] * len(groups), 10.0)
    of_border = {"border": border, "border_strengths": border_strengths}
    options = {"roi": roi, "rigidity": 10.0, "strengths": strengths, "planes": planes, "twins": joined, **of_border}
    return bind_input_of(vertices, triangles, anchors, pieces, **options)


def half(vertices, triangles, axes, groups_of, **options):
    """(numbers, triangles, BindInput) of the part above zero; groups_of(vertices): lists of vertex numbers."""
    numbers, own = part(vertices, triangles, axes)
    cut = vertices[numbers]
    joined = [np.where(np.abs(cut[:, axis]) < 1e-6, np.arange(len(cut)), -1).astype(np.int32) for axis in axes]
    return numbers, own, bind_input(cut, own, groups_of(cut), rows(axes), np.array(joined), **options)


def kinds(vertices):
    """n: 0 at the top and 1 around the middle, which the seam goes through, 2 at the side, apart from it; else -1."""
    side, height = np.abs(vertices[:, 0]), vertices[:, 2] / 2.0
    return np.select([height > 0.75, np.abs(height) < 0.05, (side > 0.6) & (height > 0.1)], [0, 1, 2], -1)


def three_handles(vertices):
    return [np.flatnonzero(kinds(vertices) == kind) for kind in range(3)]


def solved(given, triangles, positions, weights=None):
    """n x 3 and the Deformer: as session.solve_steps."""
    whole, deformer = given.solver_mesh, native_calls.bound(given, triangles)
    solution = deformer.solve(whole.targets(positions), weights=whole.weights(weights))
    return whole.cut_back(solution.vertices), solution, deformer


def symmetric(vertices, triangles, groups, axis=0, **options):
    corners, starts = faces(triangles)
    found = whole_mesh.partners(vertices.astype(np.float32), corners, starts, (*unit(axis), 0.0))
    return bind_input(vertices, triangles, groups, rows([axis]), found[None], **options)


def moves(points, axes=(0,)):
    """k x 3: lifts the top and bends it forward, and pulls the side out; along all planes that go through these."""
    kind = kinds(points)[:, None]
    degrees, forward = (0.0, 0.0) if 1 in axes else (34.4, 0.1)
    turn = rotation_about(unit(0), degrees)
    lifted = (points - [0.0, 0.0, 1.2]) @ turn.T + [0.0, 0.0, 1.5] - points
    return np.where(kind == 0, lifted, np.where(kind == 2, [0.3, forward, 0.0], 0.0))


def bent(given, axes=(0,)):
    return given.anchor_rest + moves(given.anchor_rest, axes)


@pytest.mark.parametrize("axes", AXES)
def test_the_whole_of_a_part_is_the_body(axes):
    vertices, triangles = body()
    numbers, own, given = half(vertices, triangles, axes, three_handles)
    whole = given.solver_mesh
    assert len(whole.rest) == len(vertices)
    assert np.allclose(np.sort(np.round(whole.rest, 5), axis=0), np.sort(np.round(vertices, 5), axis=0), atol=2e-5)
    assert np.allclose(whole.rest[: len(numbers)], given.rest, atol=1e-7)
    built = whole.triangles(own)
    assert len(built) == len(triangles)
    assert volume(whole.rest, built) == pytest.approx(volume(vertices, triangles), rel=1e-5)
    edges = np.sort(np.concatenate([built[:, [0, 1]], built[:, [1, 2]], built[:, [2, 0]]]), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()


def posed_as_a_whole(vertices, triangles, axes, soft):
    """As an artist would do it with the modifier applied: each side of a handle set and moved by hand."""
    kind = kinds(vertices)
    signs = np.sign(np.round(vertices[:, axes], 6))
    side_of = signs[:, 0] if 0 in axes else np.ones(len(kind))  # the handle at the side does not reach that plane
    sides = np.unique(side_of[kind == 2])
    groups = [np.flatnonzero(kind == 0), np.flatnonzero(kind == 1)]
    groups += [np.flatnonzero((kind == 2) & (side_of == side)) for side in sides]
    sliders = soft and [*soft[:2], *[soft[2]] * len(sides)]
    given = bind_input(vertices, triangles, groups, soft=sliders)
    folded = given.anchor_rest.copy()
    folded[:, axes] = np.abs(folded[:, axes])
    moved = moves(folded, axes)
    moved[:, axes] *= signs[given.anchors]
    return solved(given, triangles, given.anchor_rest + moved)[0]


@pytest.mark.parametrize("soft", [None, [0.8, None, 0.7]])
@pytest.mark.parametrize("axes", [(0,), (1,), (0, 1)])
def test_a_part_is_posed_as_the_body(axes, soft):
    vertices, triangles = body()
    numbers, own, given = half(vertices, triangles, axes, three_handles, soft=soft)
    positions = bent(given, axes)
    found, _solution, _ = solved(given, own, positions)
    if soft is None:
        assert np.abs(found[given.anchors] - positions).max() < 1e-12
    truth = posed_as_a_whole(vertices, triangles, axes, soft)
    assert np.abs(truth[numbers] - found).max() < 1e-5 * given.diagonal
    assert np.abs(np.array(found) - given.rest).max() > 0.05


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_handle_across_the_plane_turns_in_it_and_keeps_its_shape(mirrored):
    """A head that is turned aside and nods only nods; it is not pressed flat."""
    vertices, triangles = body()
    if mirrored:
        given = half(vertices, triangles, (0,), three_handles)[2]
    else:
        given = symmetric(vertices, triangles, three_handles(vertices)[:2])
    top = given.handles == 0
    points = given.anchor_rest[top]
    middle = np.array([0.0, *points.mean(axis=0)[1:]])
    nod, aside = rotation_about(unit(0), 28.6), rotation_about(unit(2), 22.9)

    def met(turn, shift=(0.0, 0.0, 0.0)):
        move = given.move_in_planes(0, motion.affine(turn, middle - turn @ middle + shift))
        positions = given.anchor_rest.copy()
        positions[top] = motion.apply(move, points)
        assert np.allclose(given.solver_mesh.met(positions)[top], positions[top], atol=1e-9)
        return positions[top]

    assert np.allclose(met(nod), (points - middle) @ nod.T + middle, atol=1e-12)
    turned = met(1.2 * rotation_about(unit(2), 40.1), (0.3, 0.0, 0.0))
    assert np.allclose(turned, (points - middle) * 1.2 + middle, atol=1e-9)
    nodded = met(aside @ nod @ aside.T)
    assert 0.2 < np.arccos((nodded - middle)[0] @ (points - middle)[0] / np.sum((points - middle)[0] ** 2)) < 0.5
    uneven = motion.affine(np.diag([1.0, 2.0, 0.0]))
    assert given.move_in_planes(0, uneven) is uneven and given.move_in_planes(0, motion.IDENTITY) is motion.IDENTITY


def test_what_is_not_moved_as_one_is_projected_point_by_point():
    _numbers, _own, given = half(*body(), (0,), three_handles)
    positions = given.anchor_rest.copy()
    top = np.flatnonzero(given.handles == 0)
    positions[top] += np.random.default_rng(2).uniform(-0.2, 0.2, (len(top), 3))
    met = given.solver_mesh.met(positions)
    in_plane = np.abs(given.anchor_rest[:, 0]) < 1e-6
    assert np.abs(met[in_plane, 0]).max() == 0.0
    assert np.allclose(met[in_plane, 1:], positions[in_plane, 1:])
    assert np.allclose(met[~in_plane], positions[~in_plane])


def test_influences_are_those_of_what_is_mirrored():
    _numbers, _own, given = half(*body(), (0,), three_handles, soft=[0.6, 0.2, 0.4])
    weights = np.linspace(0.0, 1.0, len(given.anchors))
    whole = given.solver_mesh
    doubled = whole.weights(np.stack([weights, weights**2]))
    assert doubled.shape == (2, len(whole.anchors)) and whole.weights(None) is None
    for anchor, weight in zip(given.anchors, weights, strict=True):
        image = np.abs(np.abs(whole.rest[whole.anchors, 0]) - whole.rest[anchor, 0]) < 1e-6
        image &= (np.abs(whole.rest[whole.anchors, 1:] - whole.rest[anchor, 1:]) < 1e-6).all(axis=1)
        assert image.sum() == (1 if whole.rest[anchor, 0] == 0.0 else 2)
        assert np.allclose(doubled[:, image], [[weight], [weight**2]])


def test_a_solve_begins_at_what_is_shown():
    vertices, triangles = body()
    _numbers, own, given = half(vertices, triangles, (0,), three_handles)
    found, solution, deformer = solved(given, own, bent(given))
    start = given.solver_mesh.start(found)
    assert np.abs(start - solution.vertices).max() < 1e-3
    again = deformer.solve(given.solver_mesh.targets(bent(given)), start=start)
    assert np.abs(given.solver_mesh.cut_back(again.vertices) - found).max() < 1e-3 * given.diagonal


# -- what depends on it ----------------------------------------------------------------------------------------------


def test_what_holds_the_images_counts():
    """Two vertices beside the plane hold four of the body."""
    _numbers, own, given = half(*body(), (0,), three_handles)
    two = [np.array([np.argmax(given.rest[:, 2] + given.rest[:, 0]), np.argmin(given.rest[:, 2] - given.rest[:, 0])])]
    bind_input(given.rest, own, two, given.planes, given.twins).check()
    with pytest.raises(SceneError, match="2 fixed points cannot hold"):
        bind_input(given.rest, own, two).check()


def test_a_soft_border_is_that_of_the_body():
    vertices, triangles = body()
    freedom = np.clip((vertices[:, 2] + 2.0) / 3.0, 0.05, 1.0)
    whole_body = bind_input(vertices, triangles, three_handles(vertices), freedom=freedom)
    numbers, own = part(vertices, triangles, (0,))
    _numbers, _own, given = half(vertices, triangles, (0,), three_handles, freedom=freedom[numbers])
    whole = given.solver_mesh
    assert len(own) and len(whole.border) == len(whole_body.border)
    places = {
        tuple(np.round(vertices[v], 4) + 0.0): s
        for v, s in zip(whole_body.border, whole_body.solver_mesh.border_strengths, strict=True)
    }
    expected = [places[tuple(np.round(whole.rest[v], 4) + 0.0)] for v in whole.border]
    assert np.allclose(whole.border_strengths, expected)
    assert not np.isin(whole.border, whole.anchors).any()
