# SPDX-License-Identifier: GPL-3.0-or-later
"""Fitting one figure onto another that has other faces and other proportions."""

import dataclasses
import functools

import numpy as np
import pytest
from support import figure_body
from support.rings import fan, quads, triangles
from support.wrap_calls import wrapped

from addon.errors import SceneError
from addon.scene.surface import Surface
from addon.wrapping.bridge.wrapping import Wrap, WrapInput
from native.benchmarks import shape_metrics
from native.benchmarks.rigid import rotation_about


def landmarks(points):
    """Vertices that anybody would pick: top, hands, toes and heels, seat and breast, of a figure that faces -Y."""
    left, low = points[:, 0] > 0.0, points[:, 2] < 0.15 * points[:, 2].max()
    middle = np.abs(points[:, 0]) < 0.03
    trunk = middle & (np.abs(points[:, 2] / points[:, 2].max() - 0.6) < 0.02)
    anywhere = np.ones(len(points), bool)
    picks = [(points[:, 2], anywhere), (points[:, 0], anywhere), (-points[:, 0], anywhere)]
    for side in (left, ~left):
        picks += [(-points[:, 1], side & low), (points[:, 1], side & low)]
    picks += [(points[:, 1], trunk), (-points[:, 1], trunk)]
    return np.array([np.where(where, key, -np.inf).argmax() for key, where in picks], np.int32)


def turned(points, scale=0.4):
    """Somewhere else, of another size, looking another way."""
    return scale * points @ rotation_about((0, 0, 1), 126.0).T + [3.0, -1.0, 0.5]


@functools.lru_cache(maxsize=1)
def two_figures():
    """WrapInput of a figure onto a coarser one with shorter legs, elsewhere."""
    one, other = figure_body.body(1.0, 0.03), figure_body.body(0.9, 0.036)
    target = turned(other.vertices)
    return WrapInput(
        one.vertices, triangles(one.quads), target, triangles(other.quads),
        landmarks(one.vertices), target[landmarks(other.vertices)],
    )  # fmt: skip


@functools.lru_cache(maxsize=1)
def fitted():
    return wrapped(two_figures())


@pytest.mark.slow
def test_one_figure_lies_on_the_other_and_nothing_is_turned_over():
    given, found = two_figures(), fitted()
    share = found.distance / given.diagonal
    assert share.mean() < 0.002
    away = Surface(given.target, given.target_triangles).nearest(found.positions)[3]
    np.testing.assert_allclose(found.distance, away, atol=1e-12)
    assert found.flipped == 0
    assert shape_metrics.flipped_triangles(found.positions, given.start(), given.triangles) == 0
    back = Surface(found.positions, given.triangles).nearest(given.target)[3] / given.diagonal
    assert back.mean() < 0.002, "no part of the other figure is left out"
    assert np.linalg.norm(found.positions[given.picked] - given.points, axis=1).max() < 0.02 * given.diagonal


def test_the_same_bits_twice():
    assert np.array_equal(wrapped(two_balls()).positions, wrapped(two_balls()).positions)


@pytest.mark.slow
def test_what_the_other_has_not_stays_in_shape():
    """A ball with a horn onto one without: the horn is drawn nowhere, and keeps its length."""
    vertices, triangles = ball(24, 32)
    axis = vertices[:, 2] > np.cos(0.2)
    horned = vertices.copy()
    horned[axis] += [0.0, 0.0, 1.0] * ((vertices[axis, 2:] - np.cos(0.2)) / (1.0 - np.cos(0.2)))
    other, faces = ball(15, 20)
    other *= [1.1, 1.0, 0.95]
    found = wrapped(WrapInput(horned, triangles, other, faces, np.zeros(0, np.int32), np.zeros((0, 3))))
    tip = int(horned[:, 2].argmax())
    assert found.positions[tip, 2] > 1.7
    on_ball = vertices[:, 2] < np.cos(0.5)
    diagonal = np.linalg.norm(np.ptp(other, axis=0))
    assert found.distance[on_ball].mean() < 0.002 * diagonal
    assert found.distance[tip] > 0.2 * diagonal
    assert found.flipped == 0


def test_a_part_of_its_own_without_partner_and_a_loose_vertex():
    """Teeth inside a head, say: they go along with nothing, and everything stays finite."""
    vertices, triangles = ball(16, 20)
    inner, inner_faces = ball(8, 10)
    both = np.concatenate([vertices, 0.3 * inner, [[0.1, 0.2, 0.3]]])
    faces = np.concatenate([triangles, inner_faces + len(vertices)]).astype(np.int32)
    other, other_faces = ball(12, 16)
    given = WrapInput(both, faces, 1.1 * other, other_faces, np.zeros(0, np.int32), np.zeros((0, 3)))
    found = wrapped(given)
    assert np.isfinite(found.positions).all()
    assert found.distance[: len(vertices)].mean() < 0.002 * given.diagonal
    np.testing.assert_allclose(found.positions[-1], both[-1])


def ball(rings, around):
    """A closed unit ball with poles on Z."""
    polar = np.pi * np.arange(1, rings) / rings
    angle = 2.0 * np.pi * np.arange(around) / around
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rows = [np.column_stack([np.sin(p) * circle, np.full(around, np.cos(p))]) for p in polar]
    vertices = np.concatenate([[[0.0, 0.0, 1.0]], *rows, [[0.0, 0.0, -1.0]]])
    sides = triangles(quads(rings - 1, around, first=1)[:, [0, 3, 2, 1]])
    last = len(vertices) - 1
    ends = fan(0, np.arange(around) + 1), fan(last, np.arange(-around, 0) + last)[:, ::-1]
    return vertices, np.concatenate([ends[0], sides, ends[1]]).astype(np.int32)


def test_a_flipped_triangle_is_found_and_a_turned_mesh_is_none():
    vertices, triangles = ball(12, 16)
    assert not Surface(turned(vertices), triangles).folded().any()
    folded = vertices.copy()
    folded[40] += 2.5 * (vertices[41] - vertices[40])
    assert Surface(folded, triangles).folded().any()


def two_balls():
    """WrapInput of a ball onto a smaller one, elsewhere."""
    vertices, triangles = ball(12, 16)
    other, faces = ball(9, 14)
    picked = np.array([0, 1, 5, len(vertices) - 1], np.int32)
    return WrapInput(vertices, triangles, turned(other), faces, picked, turned(vertices[picked]))


LINE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])


@pytest.mark.parametrize(
    "fields, words",
    [
        (lambda g: {"triangles": np.zeros((0, 3), np.int32)}, "no faces"),
        (lambda g: {"target_triangles": np.zeros((0, 3), np.int32)}, "no faces"),
        (lambda g: {"vertices": np.where(np.arange(len(g.vertices))[:, None] == 5, np.nan, g.vertices)}, "1 vertex of"),
        (lambda g: {"target": np.zeros_like(g.target)}, "in one place"),
        (lambda g: {"picked": g.picked[:2], "points": g.points[:2]}, "2 pairs"),
        (lambda g: {"picked": g.picked[:3], "points": LINE}, "not in one line"),
        (lambda g: {"picked": np.zeros_like(g.picked)}, "same vertex"),
        (lambda g: {"picked": g.picked + 10**6}, "178 vertices"),
        (lambda g: {"points": np.full_like(g.points, np.nan)}, "not a number"),
        (lambda g: {"picked": g.picked[:0], "points": g.points[:0]}, "do not lie over each other"),
    ],
)
def test_what_cannot_be_fitted_is_told(fields, words):
    with pytest.raises(SceneError, match=words):
        Wrap(dataclasses.replace(two_balls(), **fields(two_balls())))
