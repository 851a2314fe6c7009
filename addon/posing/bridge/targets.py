# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the anchors go: from controls, from the shape key that the artist edits, or from the rest shape."""

from dataclasses import dataclass

import numpy as np

from ... import wording
from ...errors import SceneError
from ...scene import rig_space, shape_keys
from ...scene.core import motion
from . import control_places, controls


@dataclass(frozen=True, eq=False)
class Targets:
    """positions: k x 3 float64, object space, in the order of the anchors.

    weights: k float64, how much each counts, 0 to 1; None where all count fully.

    pose: n x 3 float32 of the shape key that anchors were moved in, or None if no handle follows it.
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


def enabled_handles(obj):
    """The handles that take part, in the order of the list; anchors have their numbers."""
    return [handle for handle in obj.meanvalue.handles if handle.is_enabled]


def problem(obj):
    """Why there are no targets, in words, or None. Cheap enough for drawing."""
    return handles_problem(obj) or shape_keys.result_problem(obj)


def handles_problem(obj):
    """As problem(), but for where the result would go."""
    handles = enabled_handles(obj)
    for handle in handles:
        if handle.follows == 'CONTROL':
            found = controls.problem(obj, handle)
            if found:
                return found
    return shape_keys.pose_problem(obj) if _needs_pose(handles) else None


def pose_key(obj):
    """Name of the shape key that anchors are moved in, or "" if none follows one."""
    follows_shape = any(handle.follows == 'SHAPE' for handle in enabled_handles(obj))
    return obj.active_shape_key.name if follows_shape and shape_keys.pose_problem(obj) is None else ""


def gather(obj, bind_input):
    """The Targets of `obj`, with what its rig does measured now, and controls gone along with it.

    @throws SceneError.
    """
    found = problem(obj)
    if found:
        raise SceneError(found)
    space = rig_space.measure(obj)
    follow_rig(obj, bind_input, space)
    return gather_behind(obj, bind_input, space)


def gather_behind(obj, bind_input, space, known=None):
    """The Targets of `obj`, which has no problem(); space: its SeenSpace, or None; known: see positions().

    @throws SceneError.
    """
    moved_in = pose_key(obj)
    pose = shape_keys.pose_positions(obj) if moved_in else None
    counts = influences(obj, bind_input)
    weights = None if (counts == 1.0).all() else counts
    return Targets(positions(obj, bind_input, pose, space, known), weights, pose, moved_in)


def positions(obj, bind_input, pose, space, known=None):
    """k x 3 float64: where the key has to have the anchors now, for them to be seen where their controls have them.

    pose: as in Targets; space: the SeenSpace of now, None where what is seen is the key. For what has no problem().
    known: {name of a handle: (its move in the key's space, its targets)}: those that have not moved since keep their
    targets, whatever the rig does; brought up to date.

    @throws SceneError.
    """
    placed = bind_input.anchor_rest.copy()
    if pose is not None:
        for members, _ in _members(obj, bind_input, 'SHAPE'):
            placed[members] = pose[bind_input.anchors][members]
    is_moved = np.zeros(len(placed), bool)  # those that `placed` has where they are to be seen, so far
    moves = []
    for members, handle in _members(obj, bind_input, 'CONTROL'):
        transform = control_places.rig_transform(space, handle, bind_input.anchors[members])
        move = controls.move(obj, handle, transform)
        former = known.get(handle.name) if known is not None else None
        if former is not None and motion.same(former[0], move):
            placed[members] = former[1]
            continue
        if space is None:
            placed[members] = motion.apply(move, placed[members])
        elif move is not motion.IDENTITY:
            seen = space.seen[bind_input.anchors[members]]
            placed[members] = motion.apply(transform @ move @ np.linalg.inv(transform), seen)
            is_moved |= members
        _require_numbers(handle, placed[members])
        moves.append((handle.name, move, members))
    if is_moved.any():
        placed[is_moved] = _in_key(obj, bind_input, space, is_moved, placed[is_moved])
    if known is not None:
        known.update({name: (move, placed[members]) for name, move, members in moves})
    return placed


def follow_rig(obj, bind_input, space):
    """Puts the controls that go along with the rig to where it has their handles."""
    for members, handle in _members(obj, bind_input, 'CONTROL'):
        if handle.control is not None:
            transform = control_places.rig_transform(space, handle, bind_input.anchors[members])
            control_places.follow_rig(obj, handle, transform)


def _members(obj, bind_input, follows):
    """(k bool, handle) of the handles that take part and follow that."""
    for number, handle in enumerate(enabled_handles(obj)):
        if handle.follows == follows:
            yield bind_input.handles == number, handle


def _in_key(obj, bind_input, space, is_moved, wanted):
    """Where the key has to have the anchors of the mask `is_moved` for them to be seen at `wanted`.

    @throws SceneError.
    """
    anchors = bind_input.anchors[is_moved]
    _require_depth(obj, bind_input, space, is_moved)
    if space.is_affine or rig_space.looks_at_neighbours(obj):  # mended alone, vertices overshoot what smooths them
        return space.in_key(anchors, wanted)
    with rig_space.evaluating(obj) as evaluate:
        return space.in_key(anchors, wanted, evaluate)


def _require_depth(obj, bind_input, space, is_moved):
    """@throws SceneError if the rig squeezes anchors, so that no key can bring them to where they are wanted."""
    for members, handle in _members(obj, bind_input, 'CONTROL'):
        flat = int(space.is_flat[bind_input.anchors[members & is_moved]].sum())
        if flat:
            raise SceneError(
                f"{rig_space.named(obj)} squeezes {wording.vertices(flat)} of handle '{handle.name}' flat, so no shape "
                f"key can move {'it' if flat == 1 else 'them'} to where the control is. Give the bones there a size, "
                "or turn the handle off"
            )


def _require_numbers(handle, points):
    if not np.isfinite(points).all():
        raise SceneError(
            f"The control of handle '{handle.name}' is at a place that is not a number. Reset its transform"
        )


def influences(obj, bind_input):
    """k float64, 0 to 1: how much each anchor counts now. Below 1 only for soft handles, by their controls."""
    counts = np.ones(len(bind_input.anchors))
    for number, handle in enumerate(enabled_handles(obj)):
        if handle.is_soft and handle.follows == 'CONTROL' and handle.control is not None:
            counts[bind_input.handles == number] = handle.control.meanvalue.influence
    return counts


def _needs_pose(handles):
    """Without controls it is the shape key alone that can pose anything; beside controls it is welcome."""
    return all(handle.follows != 'CONTROL' for handle in handles)
