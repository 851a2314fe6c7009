# SPDX-License-Identifier: GPL-3.0-or-later
"""What of a handle's motion is the same on all sides of mirror planes that go through the handle."""

import numpy as np

from ...scene.core import rigid

#: A handle is moved as one if no vertex is farther from where that has it than this share of the handle's size.
AS_ONE = 1e-4

#: What differs less from what is the same on all sides is left as it is, to the bit.
THE_SAME = 1e-6

#: Points are in one line, which leaves a turn open, if they are no farther from it than this share of their extent.
IN_LINE = 1e-4


def agreed(points, goals, turns, shifts):
    """... x k x 3: where k x 3 `points` go instead of to ... x k x 3 `goals`.

    turns h x 3 x 3, shifts h x 3: the reflections, and those after each other, that take the handle to itself; the
    identity first. A motion that moves, turns and scales all as one keeps its scale, the nearest turn that commutes
    with the reflections, and what moves the handle's middle along their planes: a head that is turned aside stays as
    it is, and one that nods does. Other motions are returned as they are.
    """
    middle = points.mean(axis=0)
    arms = points - middle
    size = np.abs(arms).max(initial=0.0)
    if np.linalg.matrix_rank(arms, tol=IN_LINE * size * np.sqrt(len(points))) < 2:
        return goals
    is_known = np.isfinite(goals).all(axis=(-1, -2), keepdims=True)
    known = np.where(is_known, goals, points)
    turn = rigid.fit_rotations(arms, known)
    goal_middle = known.mean(axis=-2, keepdims=True)
    along_arms = (known - goal_middle) * (arms @ np.swapaxes(turn, -1, -2))
    scale = along_arms.sum(axis=(-1, -2), keepdims=True) / (arms**2).sum()
    fitted = goal_middle + scale * (arms @ np.swapaxes(turn, -1, -2))
    centre = (turns @ middle + shifts).mean(axis=0)
    moved = goal_middle + scale * ((centre - middle)[None] @ np.swapaxes(turn, -1, -2)) - centre
    along = moved @ turns.mean(axis=0).T
    mean_turn = np.einsum("hij,...jk,hlk->...il", turns, turn, turns) / len(turns)
    nearest = rigid.nearest_rotations(mean_turn)
    result = centre + along + scale * ((points - centre) @ np.swapaxes(nearest, -1, -2))
    is_as_one = _most(fitted - known) <= AS_ONE * size
    is_changed = _most(result - known) > THE_SAME * size
    return np.where(is_known & is_as_one & is_changed, result, goals)


def _most(offsets):
    return np.abs(offsets).max(axis=(-1, -2), keepdims=True)
