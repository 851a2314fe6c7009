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

    pose: n x 3 float32 of the shape key that anchors were moved in, or None if no group follows it.
    pose_key: its name, or "".
    """

    positions: np.ndarray
    pose: np.ndarray | None
    pose_key: str


def enabled_groups(obj):
    """The anchor groups that take part, in the order of the list; pieces are numbered so."""
    return [group for group in obj.meanvalue.anchor_groups if group.is_enabled]


def problem(obj):
    """Why there are no targets, in words, or None. Cheap enough for drawing."""
    groups = enabled_groups(obj)
    for group in groups:
        if group.follows == 'CONTROL':
            found = controls.problem(obj, group)
            if found:
                return found
    if _needs_pose(groups):
        found = shape_keys.pose_problem(obj)
        if found:
            return found
    return shape_keys.result_problem(obj)


def gather(obj, bind_input):
    """The Targets of `obj`. @throws SceneError."""
    found = problem(obj)
    if found:
        raise SceneError(found)
    groups = enabled_groups(obj)
    positions = bind_input.rest[bind_input.anchors].astype(np.float64)
    pose, pose_key = None, ""
    if any(group.follows == 'SHAPE' for group in groups) and shape_keys.pose_problem(obj) is None:
        pose, pose_key = shape_keys.pose_positions(obj), obj.active_shape_key.name
    for number, group in enumerate(groups):
        if group.follows == 'REST' or (group.follows == 'SHAPE' and pose is None):
            continue
        members = bind_input.pieces == number
        if group.follows == 'SHAPE':
            positions[members] = pose[bind_input.anchors][members]
        else:
            positions[members] = motion.apply(controls.move(obj, group), positions[members])
    return Targets(positions, pose, pose_key)


def prepare_result(obj):
    """Makes the shape key for the result, and shows it, if that can be done."""
    if obj.type == 'MESH' and obj.mode == 'OBJECT' and shape_keys.result_problem(obj) is None:
        follows_shape = any(group.follows == 'SHAPE' for group in enabled_groups(obj))
        has_pose = follows_shape and shape_keys.pose_problem(obj) is None
        shape_keys.ensure_result_key(obj, obj.active_shape_key.name if has_pose else "")


def _needs_pose(groups):
    """Without controls it is the shape key alone that can pose anything; beside controls it is welcome."""
    return all(group.follows != 'CONTROL' for group in groups)
