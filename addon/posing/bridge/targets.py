# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the anchors go: to their controls, or, once, to where a shape key has them."""

from dataclasses import dataclass

import numpy as np

from ... import wording
from ...errors import SceneError, require_none
from ...scene import rig_space, shape_keys
from ...scene.core import motion
from . import control_places, controls, orphans


@dataclass(frozen=True, eq=False)
class Targets:
    """Where the k anchors go, in their order."""

    positions: np.ndarray  # k x 3 float64, object space
    weights: np.ndarray | None  # k float64, how much each counts, 0 to 1; None where all count fully
    held_back: tuple = ()  # names of the handles that go no farther than limbs reach

    def is_near(self, other, distance):
        """Whether no anchor is farther than `distance` from where `other` has it, and each counts and is held alike."""
        count_alike = self.weights is other.weights or np.array_equal(self.weights, other.weights)
        is_near = bool(np.abs(self.positions - other.positions).max(initial=0.0) <= distance)
        return count_alike and is_near and self.held_back == other.held_back


def enabled_handles(obj):
    """The handles that take part, in the order of the list; anchors have their numbers."""
    return [handle for handle in obj.meanvalue.handles if is_taking_part(handle)]


def is_taking_part(handle):
    return handle.is_enabled and not orphans.is_deleted(handle)


def moved_handles(obj):
    """Those that take part and follow a control that is there. On any thread."""
    return [each for each in enabled_handles(obj) if each.follows == 'CONTROL' and each.control is not None]


def followed_handles(obj):
    """Those of them whose controls can be followed now."""
    return [handle for handle in moved_handles(obj) if controls.problem(obj, handle) is None]


def problem(obj):
    """Why there are no targets, in words, or None. Cheap enough for drawing."""
    return handles_problem(obj) or shape_keys.result_problem(obj)


def handles_problem(obj):
    """As problem(), but for where the result would go."""
    handles = enabled_handles(obj)
    for handle in handles:
        found = controls.problem(obj, handle)
        if found:
            return found
    if all(handle.follows == 'REST' for handle in handles):
        return "Only pins hold the mesh, so nothing is posed. Add a handle, or press on the mesh with Grab and drag"
    return None


def gather(obj, bind_input, key=""):
    """The Targets of `obj`, with its rig measured now, and controls gone along with it; or, of all handles and pins,
    where the shape key `key` has their vertices. @throws SceneError."""
    if key:
        placed = shape_keys.checked(obj, key)[bind_input.anchors].astype(np.float64)
        return Targets(_in_planes(bind_input, placed), _weights(obj, bind_input))
    require_none(problem(obj))
    space = rig_space.measure(obj)
    follow_rig(obj, bind_input, space)
    return gather_behind(obj, bind_input, space)


def gather_behind(obj, bind_input, space, known=None):
    """The Targets of `obj`, which has no problem(). space, known: see positions(). @throws SceneError."""
    placed, held_back = within_reach(obj, bind_input, positions(obj, bind_input, space, known))
    return Targets(placed, _weights(obj, bind_input), held_back)


def positions(obj, bind_input, space, known=None):
    """k x 3 float64: where the key has to have the anchors now, for them to be seen where their controls have them.

    space: the SeenSpace of now, None where what is seen is the key. For what has no problem().
    known: {name of a handle: (its move in the key's space, its targets)}: those that have not moved since keep their
    targets, whatever the rig does; brought up to date. @throws SceneError.
    """
    placed = bind_input.anchor_rest.copy()
    is_moved = np.zeros(len(placed), bool)  # those that `placed` has where they are to be seen, so far
    moves = []
    for number, members, handle in _moving(obj, bind_input):
        transform = control_places.rig_transform(space, handle, bind_input.anchors[members])
        move = bind_input.move_in_planes(number, control_places.move(obj, handle, transform))
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
        if not np.isfinite(placed[members]).all():  # or they would be other targets whenever they are looked at
            raise SceneError(f"The control of handle '{handle.name}' is at no numbers. Reset its transform")
        moves.append((handle.name, move, members))
    if is_moved.any():
        placed[is_moved] = _in_key(obj, bind_input, space, is_moved, placed[is_moved])
    if known is not None:
        known.update({name: (move, placed[members]) for name, move, members in moves})
    return placed


def _in_planes(bind_input, placed):
    """k x 3 float64 `placed`, but of handles that it moves, turns and scales as one what is the same on both sides of
    planes that they lie across."""
    placed = placed.copy()
    for number in np.unique(bind_input.handles) if bind_input.planes is not None else ():
        members = bind_input.handles == number
        before, after = bind_input.anchor_rest[members], placed[members]
        spreads = [np.linalg.norm(points - points.mean(axis=0)) for points in (before, after)]
        scale = spreads[1] / spreads[0] if spreads[0] > 0.0 else 1.0
        move = motion.fitted(scale * before, after) @ motion.affine(scale * np.eye(3))
        is_as_one = np.abs(motion.apply(move, before) - after).max() <= motion.EVEN * spreads[1]
        goal = bind_input.move_in_planes(number, move)
        if is_as_one and not motion.same(goal, move):
            placed[members] = motion.apply(goal, before)
    return placed


def within_reach(obj, bind_input, placed):
    """(k x 3 targets that limbs reach, names of the handles that `placed` has farther away)."""
    limits = None if obj.meanvalue.stretch else bind_input.limits
    if limits is None or not len(limits.lengths):
        return placed, ()
    shape = bind_input.rest[limits.vertices].astype(np.float64)
    is_held = limits.handles >= 0
    shape[is_held] = placed[np.searchsorted(bind_input.anchors, limits.vertices[is_held])]
    handles, placed = enabled_handles(obj), placed.copy()
    shifts = limits.held_back(shape, [number for number, each in enumerate(handles) if each.follows == 'CONTROL'])
    for number, shift in shifts.items():
        placed[bind_input.handles == number] += shift
    return placed, tuple(handles[number].name for number in sorted(shifts))


def held_back_notes(names):
    """A sentence on handles that are held back."""
    if names:
        are = "is" if len(names) == 1 else "are"
        yield f"{wording.quoted(names)} {are} out of reach. Advanced > Stretch lets limbs stretch to there"


def follow_rig(obj, bind_input, space):
    """Puts the controls that go along with the rig to where it has their handles."""
    for _, members, handle in _moving(obj, bind_input):
        if handle.control is not None:
            transform = control_places.rig_transform(space, handle, bind_input.anchors[members])
            control_places.follow_rig(obj, handle, transform)


def _moving(obj, bind_input):
    """(number, k bool, handle) of the handles that take part and follow a control."""
    for number, handle in enumerate(enabled_handles(obj)):
        if handle.follows == 'CONTROL':
            yield number, bind_input.handles == number, handle


def _in_key(obj, bind_input, space, is_moved, wanted):
    """Where the key has to have the anchors of the mask `is_moved` to be seen at `wanted`. @throws SceneError."""
    anchors = bind_input.anchors[is_moved]
    for _, members, handle in _moving(obj, bind_input):
        flat = int(space.is_flat[bind_input.anchors[members & is_moved]].sum())
        if flat:
            count = f"{wording.vertices(flat)} of handle '{handle.name}'"
            raise SceneError(f"{rig_space.named(obj)} squeezes {count} flat. Scale the bones there, or turn it off")
    is_smoothed = any(each.type in rig_space.NEIGHBOURLY for each in rig_space.deformers(obj))
    if space.is_affine or is_smoothed:  # mended alone, vertices overshoot what smooths them
        return space.in_key(anchors, wanted)
    with rig_space.evaluating(obj) as evaluate:
        return space.in_key(anchors, wanted, evaluate)


def _weights(obj, bind_input):
    counts = influences(obj, bind_input)
    return None if (counts == 1.0).all() else counts


def influences(obj, bind_input):
    """k float64, 0 to 1: how much each anchor counts now. Below 1 only for soft handles, by their controls."""
    counts = np.ones(len(bind_input.anchors))
    for number, handle in enumerate(enabled_handles(obj)):
        if handle.is_soft and handle.follows == 'CONTROL' and handle.control is not None:
            counts[bind_input.handles == number] = handle.control.meanvalue.influence
    return counts
