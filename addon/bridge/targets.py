# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the anchors go: from controls, from the shape key that the artist edits, or from the rest shape."""

from dataclasses import dataclass

import numpy as np

from ..core import motion
from ..errors import SceneError
from . import controls, shape_keys


@dataclass(frozen=True, eq=False)
class Targets:
    """positions: k x 3 float64, object space, in the order of the anchors.

    weights: k float64, how much each counts, 0 to 1; None where all count fully.

    pose: n x 3 float32 of the shape key that anchors were moved in, or None if no group follows it.
    pose_key: its name, or "".
    """

    positions: np.ndarray
    weights: np.ndarray | None
    pose: np.ndarray | None
    pose_key: str

    def is_near(self, other, distance):
        """Whether no anchor is farther than `distance` from where `other` has it, and each counts the same."""
        if self.weights is None or other.weights is None:
            count_alike = self.weights is other.weights
        else:
            count_alike = np.array_equal(self.weights, other.weights)
        return count_alike and bool(np.abs(self.positions - other.positions).max(initial=0.0) <= distance)


def enabled_groups(obj):
    """The anchor groups that take part, in the order of the list; pieces are numbered so."""
    return [group for group in obj.meanvalue.anchor_groups if group.is_enabled]


def problem(obj):
    """Why there are no targets, in words, or None. Cheap enough for drawing."""
    return handles_problem(obj) or shape_keys.result_problem(obj)


def handles_problem(obj):
    """As problem(), but for where the result would go."""
    groups = enabled_groups(obj)
    for group in groups:
        if group.follows == 'CONTROL':
            found = controls.problem(obj, group)
            if found:
                return found
    return shape_keys.pose_problem(obj) if _needs_pose(groups) else None


def pose_key(obj):
    """Name of the shape key that anchors are moved in, or "" if none follows one."""
    follows_shape = any(group.follows == 'SHAPE' for group in enabled_groups(obj))
    return obj.active_shape_key.name if follows_shape and shape_keys.pose_problem(obj) is None else ""


def gather(obj, bind_input):
    """The Targets of `obj`. @throws SceneError."""
    found = problem(obj)
    if found:
        raise SceneError(found)
    moved_in = pose_key(obj)
    pose = shape_keys.pose_positions(obj) if moved_in else None
    counts = influences(obj, bind_input)
    weights = None if (counts == 1.0).all() else counts
    return Targets(positions(obj, bind_input, pose), weights, pose, moved_in)


def positions(obj, bind_input, pose):
    """k x 3 float64: where the anchors go now; pose: as in Targets. For what has no problem(). @throws SceneError."""
    placed = bind_input.anchor_rest.copy()
    for number, group in enumerate(enabled_groups(obj)):
        if group.follows == 'REST' or (group.follows == 'SHAPE' and pose is None):
            continue
        members = bind_input.pieces == number
        if group.follows == 'SHAPE':
            placed[members] = pose[bind_input.anchors][members]
        else:
            placed[members] = motion.apply(controls.move(obj, group), placed[members])
            if not np.isfinite(placed[members]).all():
                raise SceneError(
                    f"The control of handle '{group.name}' is at a place that is not a number. Reset its transform"
                )
    return placed


def influences(obj, bind_input):
    """k float64, 0 to 1: how much each anchor counts now. Below 1 only for soft handles, by their controls."""
    counts = np.ones(len(bind_input.anchors))
    for number, group in enumerate(enabled_groups(obj)):
        if group.is_soft and group.follows == 'CONTROL' and group.control is not None:
            counts[bind_input.pieces == number] = group.control.meanvalue.influence
    return counts


def prepare_result(obj):
    """Makes the shape key for the result, and shows it, if that can be done."""
    if obj.type == 'MESH' and obj.mode == 'OBJECT' and shape_keys.result_problem(obj) is None:
        shape_keys.ensure_result_key(obj, pose_key(obj))


def _needs_pose(groups):
    """Without controls it is the shape key alone that can pose anything; beside controls it is welcome."""
    return all(group.follows != 'CONTROL' for group in groups)
