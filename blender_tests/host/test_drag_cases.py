# SPDX-License-Identifier: GPL-3.0-or-later
"""What bench_drag drags, and how: the generated creature, the tube, and the jobs of each set-up. No times."""

from dataclasses import replace

import numpy as np
import pytest

from native.benchmarks import bench_drag, drag_cases, generated_creature, generated_meshes, rigid

CREATURE = drag_cases.Model("creature", *generated_creature.creature(6_500))
BALL, BALL_FACES = generated_meshes.sphere(8)


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
