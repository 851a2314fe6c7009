# SPDX-License-Identifier: GPL-3.0-or-later
"""What bench_drag drags, and how: the generated creature, the tube, and the jobs of each set-up. No times."""

from dataclasses import replace

import numpy as np
import pytest

from native.benchmarks import bench_drag, drag_cases, generated_creature, generated_meshes, rigid, shape_metrics
from native.benchmarks.peers.job import RESTART

CREATURE = drag_cases.Model("creature", *generated_creature.creature(6_500))
BALL, BALL_FACES = generated_meshes.sphere(8)


@pytest.mark.parametrize("count", [6_500, 12_000])
def test_creature_is_closed_outward_and_well_shaped(count):
    vertices, faces = generated_creature.creature(count)
    assert 0.95 * count < len(vertices) < 1.05 * count
    assert generated_creature.is_ball(vertices, faces)
    pairs = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    assert len(shape_metrics.inner_edges(faces)) * 2 == len(pairs)
    assert np.array_equal(np.unique(faces), np.arange(len(vertices)))
    assert 0.4 < shape_metrics.volume(vertices, faces) < 0.6
    lengths = np.linalg.norm(vertices[pairs[:, 0]] - vertices[pairs[:, 1]], axis=1)
    assert lengths.max() < 2.5 * lengths.mean() and lengths.min() > 0.05 * lengths.mean()


def test_creature_is_the_same_every_time():
    vertices, faces = generated_creature.creature(6_500)
    assert np.array_equal(vertices, CREATURE.vertices) and np.array_equal(faces, CREATURE.faces)


def test_two_pieces_or_a_tunnel_are_no_ball():
    assert generated_creature.is_ball(BALL, BALL_FACES)
    assert not generated_creature.is_ball(*two_balls())
    assert not generated_creature.is_ball(BALL, BALL_FACES[1:])


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


def test_a_job_solves_both_ends_of_the_drag_from_rest_first():
    job = drag_cases.job(CREATURE, drag_cases.SINGLE, 5)
    rest, frames = job.vertices[job.anchors], job.targets[drag_cases.FRAMES_FROM :]
    assert np.array_equal(job.targets[drag_cases.FIRST], frames[0])
    assert np.array_equal(job.targets[drag_cases.LAST], frames[-1])
    assert np.array_equal(job.targets[drag_cases.AT_REST], rest)
    assert job.plan.tolist() == [RESTART] * drag_cases.FRAMES_FROM + [0] * 5


def test_patches_are_connected_discs_about_far_points():
    anchors, pieces, _ = drag_cases.handles(CREATURE.vertices, CREATURE.faces, drag_cases.PATCHES)
    radius = drag_cases.PATCH_RADIUS * np.linalg.norm(np.ptp(CREATURE.vertices, axis=0))
    edges = shape_metrics.unique_edges(CREATURE.faces)
    for piece in range(drag_cases.POINTS[drag_cases.PATCHES]):
        members = anchors[pieces == piece]
        assert len(members) >= 3
        assert np.ptp(CREATURE.vertices[members], axis=0).max() <= 2 * radius
        parts = drag_cases.part_numbers(len(CREATURE.vertices), edges[np.isin(edges, members).all(axis=1)])
        assert len(np.unique(parts[members])) == 1


def test_part_numbers_are_the_lowest_vertex_of_each_part():
    edges = np.array([[8, 7], [7, 2], [2, 5], [4, 3], [5, 9]])
    assert drag_cases.part_numbers(10, edges).tolist() == [0, 1, 2, 3, 3, 2, 6, 2, 2, 2]


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


def test_the_tube_is_open_and_bends_to_an_arc_of_its_length():
    model = drag_cases.Model("tube", *drag_cases.open_tube(), (drag_cases.ENDS,))
    assert len(model.vertices) == drag_cases.TUBE_AROUND * drag_cases.TUBE_ALONG
    assert [len(loop) for loop in shape_metrics.border_loops(model.faces)] == [drag_cases.TUBE_AROUND] * 2
    assert shape_metrics.volume(model.vertices, model.faces) > 0
    job = drag_cases.job(model, drag_cases.ENDS, 40)
    top = model.vertices[job.anchors][:, 2] == drag_cases.TUBE_LENGTH
    end = job.targets[drag_cases.LAST][top].mean(axis=0)
    angle = 40 * drag_cases.TUBE_STEP
    radius = drag_cases.TUBE_LENGTH / angle
    assert end == pytest.approx([0, radius * (1 - np.cos(angle)), radius * np.sin(angle)], abs=1e-9)


def test_goals_that_are_missed_are_named():
    row = {"model": "a", "setup": drag_cases.SINGLE, "frames": 30, "asked": 40, "median/CGAL": 0.15, "worst/CGAL": 1.5,
           "energy/cold": 1.0}  # fmt: skip
    assert bench_drag.missed(row) == ["worst", "frames"]
    assert bench_drag.missed({**row, "setup": drag_cases.PATCHES, "frames": 40}) == ["median", "worst"]
    lines = bench_drag.goal_lines([row, {"model": "b", "setup": drag_cases.SINGLE, "missing": "why"}])
    assert [line.startswith("reached") for line in lines] == [True, False, True]
    assert "worst 1.5 (a)" in lines[1]


def two_balls():
    """A ball and another beside it as one mesh."""
    return np.concatenate([BALL, BALL + np.array([5, 0, 0])]), np.concatenate([BALL_FACES, BALL_FACES + len(BALL)])
