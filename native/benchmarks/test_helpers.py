# SPDX-License-Identifier: GPL-3.0-or-later
"""What the benchmarks measure with: generated meshes, rotations, metrics, fits, drags. No times."""

from dataclasses import replace

import numpy as np
import pytest

from native.benchmarks import (
    bench_size,
    drag_cases,
    generated_creature,
    generated_meshes,
    rigid,
    shape_metrics,
)

BAR, BAR_FACES = generated_meshes.bar(600, bumpy=False)
BALL, BALL_FACES = generated_meshes.sphere(8)
CREATURE = drag_cases.Model("creature", *generated_creature.creature(6_500))


def twisted(degrees_at_top):
    """The bar, each height turned in proportion."""
    angle = np.radians(degrees_at_top) * BAR[:, 2] / generated_meshes.BAR_LENGTH
    x, y = BAR[:, 0], BAR[:, 1]
    turned = [np.cos(angle) * x - np.sin(angle) * y, np.sin(angle) * x + np.cos(angle) * y, BAR[:, 2]]
    return np.stack(turned, axis=1)


def layers(count):
    side = np.flatnonzero((BAR[:, 2] > 0.1) & (BAR[:, 2] < 9.9))
    return np.array_split(side[np.argsort(BAR[side, 2], kind="stable")], count)


def test_metrics_are_blind_to_rigid_motion():
    moved = BAR @ rigid.rotation_about([1, 2, 3], 170.0).T + [1, 2, 3]
    assert shape_metrics.edge_error(moved, BAR, BAR_FACES) < 1e-12
    assert shape_metrics.dihedral_error(moved, BAR, BAR_FACES) < 1e-5
    assert shape_metrics.flipped_triangles(moved, BAR, BAR_FACES) == 0
    assert shape_metrics.volume(moved, BAR_FACES) == pytest.approx(shape_metrics.volume(BAR, BAR_FACES))
    assert shape_metrics.bump_errors(moved, BAR, BAR_FACES, np.arange(len(BAR))) == pytest.approx((0, 0), abs=1e-9)


def test_a_vertex_pulled_through_the_surface_flips_triangles():
    folded = BALL.copy()
    vertex = int(BALL[:, 2].argmax())
    ring = np.setdiff1d(BALL_FACES[np.isin(BALL_FACES, vertex).any(axis=1)], [vertex])
    folded[vertex] += 1.7 * (BALL[ring[0]] - BALL[vertex])
    assert 0 < shape_metrics.flipped_triangles(folded, BALL, BALL_FACES) <= 4


@pytest.mark.parametrize("degrees", [60.0, 270.0])
def test_an_even_twist_is_even_also_beyond_half_a_turn(degrees):
    sections = layers(12)
    heights, turns = shape_metrics.section_turns(twisted(degrees), BAR, 2, sections)
    assert turns[-1] - turns[0] == pytest.approx(degrees * (heights[-1] - heights[0]) / 10, abs=4)
    assert shape_metrics.twist_unevenness(heights, turns) < 4


def test_bumps_may_turn_with_the_surface_but_not_flatten():
    column, row = (axis.ravel() for axis in np.meshgrid(np.arange(21.0), np.arange(21.0)))
    flat = np.stack([column, row, 0 * row], axis=1)
    bumpy = flat + np.outer(np.sin(1.5 * column) * np.sin(1.5 * row), [0, 0, 0.3])
    number = np.arange(441).reshape(21, 21)
    corners = [part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1])]
    faces = np.concatenate([np.stack(corners[:3], axis=1), np.stack([corners[k] for k in (0, 2, 3)], axis=1)])
    inner = number[6:-6, 6:-6].ravel()
    turned = bumpy @ rigid.rotation_about([1, 0, 0], 70.0).T
    assert shape_metrics.bump_errors(turned, bumpy, faces, inner) == pytest.approx((0, 0), abs=1e-9)
    assert shape_metrics.bump_errors(flat, bumpy, faces, inner)[0] == pytest.approx(1, abs=0.05)
    assert shape_metrics.bump_errors(flat - (bumpy - flat), bumpy, faces, inner)[0] == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize("setup", [drag_cases.SINGLE, drag_cases.PATCHES])
def test_one_handle_is_carried_rigidly_and_the_others_are_held(setup):
    job = drag_cases.job(CREATURE, setup, 40)
    rest, frames = job.vertices[job.anchors], job.targets[drag_cases.FRAMES_FROM :]
    assert len(frames) == 40 and len(job.plan) == len(job.targets)
    assert np.array_equal(np.unique(job.pieces), np.arange(drag_cases.POINTS[setup]))
    moving = (frames[-1] != rest).any(axis=1)
    assert len(np.unique(job.pieces[moving])) == 1
    assert not np.isin(job.pieces[~moving], job.pieces[moving]).any()
    way = frames[-1][moving].mean(axis=0) - rest[moving].mean(axis=0)
    assert np.linalg.norm(way) == pytest.approx(drag_cases.CARRY * job.diagonal)
    assert way @ (rest[moving].mean(axis=0) - job.vertices.mean(axis=0)) == pytest.approx(0, abs=1e-9)
    if setup == drag_cases.PATCHES:
        rotation, _ = rigid.rigid_fit(rest[moving], frames[-1][moving])
        assert np.degrees(np.arccos((np.trace(rotation) - 1) / 2)) == pytest.approx(drag_cases.TURN_DEG)
    steps = np.linalg.norm(np.diff(np.concatenate([rest[None], frames]), axis=0), axis=2)
    assert steps.max() < 0.006 * job.diagonal


def test_parts_without_anchors_and_what_is_not_manifold_are_left_out_for_the_peer():
    vertices, faces = two_balls()
    anchors = np.array([len(BALL) + 1, len(BALL) + 9])
    job = drag_cases.as_job(drag_cases.Model("two", vertices, faces), anchors, np.arange(2), np.array([True, False]),
                            [(np.eye(3), np.ones(3))])  # fmt: skip
    held, *left_out = drag_cases.for_peer(job)
    assert left_out == [len(BALL), 0]
    assert np.array_equal(held.faces, BALL_FACES) and np.array_equal(held.anchors, [1, 9])
    assert np.array_equal(held.vertices[held.anchors], vertices[anchors])
    assert drag_cases.for_peer(held)[1:] == (0, 0)
    doubled = replace(job, faces=np.concatenate([faces, faces[-1:]]))
    held, *left_out = drag_cases.for_peer(doubled)
    assert left_out == [len(BALL), 2] and np.array_equal(held.faces, BALL_FACES[:-1])


def two_balls():
    """A ball and another beside it as one mesh."""
    return np.concatenate([BALL, BALL + np.array([5, 0, 0])]), np.concatenate([BALL_FACES, BALL_FACES + len(BALL)])


def test_subdivided_has_four_faces_for_each_and_stays_closed():
    vertices, faces = generated_meshes.sphere(4)
    points, finer = bench_size.subdivided(vertices, faces)
    assert len(finer) == 4 * len(faces)
    assert len(points) - len(shape_metrics.unique_edges(finer)) + len(finer) == 2
    sides = np.concatenate([finer[:, [0, 1]], finer[:, [1, 2]], finer[:, [2, 0]]])
    assert len(np.unique(sides, axis=0)) == len(sides)
    assert np.isfinite(points).all()
    assert shape_metrics.volume(points, finer) > 0.8 * shape_metrics.volume(vertices, faces)
