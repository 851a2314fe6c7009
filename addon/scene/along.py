# SPDX-License-Identifier: GPL-3.0-or-later
"""The one place that writes a pose for a mesh and for all that goes along with it.

Each of these has a result key of its own. Where it goes follows from the mesh's pose alone (meanvalue.Follower); its
value is that of the mesh's key, by a driver. So a pose that fades, is muted or kept does so everywhere.
"""

import time
from typing import NamedTuple

import numpy as np

from .. import compat
from ..errors import MeanValueError
from ..solver import native_loader, session
from ..solver.core.fingerprint import digest
from . import actions, kept, key_marks, mesh_arrays, mirrors, object_model, shape_keys, subject, worn
from .core import motion, welding
from .core.point_sets import bounding_box_diagonal, require_finite
from .key_marks import Role
from .pose_object_making import remove_bare

#: Of the mesh's size: what moved less beside the mesh lies where it lay; what is posed by less is still (rounding).
SAME_PLACE, STILL = 1e-4, 1e-9

#: Keys are compared with what was written after a pause: not in a drag.
PAUSE_SECONDS = 0.25

REFUSED = "What goes along cannot be bound: {}"


class Shape(NamedTuple):
    """A mesh at rest, with one of all copies of a vertex. @throws MeanValueError where it is read."""

    rest: np.ndarray  # n x 3 float32
    first: np.ndarray  # k: the vertices that are used
    at: np.ndarray  # n: which of these a vertex is
    triangles: np.ndarray  # of these
    images: list  # as of mirrors.images()
    revision: str

    def seen(self, shape):
        """(images times k) x 3 float64: what Mirror modifiers show of n x 3 `shape`."""
        vertices = shape[self.first].astype(np.float64)
        return np.concatenate([vertices @ matrix.T + shift for matrix, shift in self.images])

    def faces(self):
        turned = [self.triangles[:, :: int(np.sign(np.linalg.det(matrix)))] for matrix, _ in self.images]
        return np.concatenate([each + number * len(self.first) for number, each in enumerate(turned)]).astype(np.int32)


def _read(obj):
    rest = shape_keys.rest_positions(obj.data)
    require_finite(rest, f"rest shape of '{obj.name}'")
    corners, starts = mesh_arrays.faces(obj.data)
    copies = welding.copies(rest, *kept.seam_settings(obj), corners, starts)
    first, at = np.unique(np.arange(len(rest)) if copies is None else copies, return_inverse=True)
    triangles = at.ravel()[mesh_arrays.triangles(obj.data, rest, corners)].reshape(-1, 3)
    images = mirrors.images(obj)
    return Shape(rest, first, at.ravel(), triangles, images, digest(rest, triangles, repr(images)))


def _signature(obj):
    mesh = obj.data
    counts = len(mesh.vertices), len(mesh.polygons)
    return compat.session_key(mesh), counts, kept.seam_settings(obj), mirrors.signature(obj)


READING = object_model.Kind(_signature, _read, lambda found: [("", found.rest)], shape_keys.result)


def _shape(obj):
    model = object_model.of(obj, READING)
    model.read(obj)
    return model.result(obj)


class Follower:
    """What goes along with a mesh in one way, as one mesh: so a button finds the shirt that it is on."""

    def __init__(self, carrier, kind, shapes, places, size):
        """carrier, shapes: Shapes; places: 4 x 4 each, from its space to the carrier's, of this size.
        @throws SolverError."""
        self.carrier, self._shapes, self.places, self._size = carrier, shapes, places, size
        self.key = [each.revision for each in (carrier, *shapes)]
        vertices = [motion.apply(place, each.rest[each.first]) for place, each in zip(places, shapes, strict=True)]
        self._ends = np.cumsum([len(each) for each in vertices])
        begins, self._vertices = self._ends - [len(each) for each in vertices], np.concatenate(vertices)
        faces = np.concatenate([each.triangles + begin for each, begin in zip(shapes, begins, strict=True)])
        meshes = carrier.seen(carrier.rest), carrier.faces(), self._vertices, faces.astype(np.int32)
        self._native = session.call(native_loader.module().Follower, *meshes, kind=kind.lower(), refused=REFUSED)

    def follow(self, shape):
        """[n x 3 float32] for the carrier's pose; at rest to the last bit where that is. @throws SolverError."""
        if np.array_equal(shape, self.carrier.rest):
            return [each.rest for each in self._shapes]
        offsets = session.call(self._native.follow, self.carrier.seen(shape), refused=REFUSED) - self._vertices
        offsets[np.abs(offsets) <= STILL * self._size] = 0.0
        own = zip(np.split(offsets, self._ends[:-1]), self._shapes, self.places, strict=True)
        return [(each.rest + (to @ np.linalg.inv(at[:3, :3]).T)[each.at]).astype(np.float32) for to, each, at in own]


class _State:
    """What is known of a mesh: the pose that is shown by all that goes along, of what, and when it was written."""

    def __init__(self):
        self.of = self.stamp = None
        self.at, self.size = 0.0, 1.0
        self.followers = {}  # of each kind
        self.places, self.problems = {}, {}  # by the session key of an object


_states = {}  # session key of the mesh: _State


def forget():
    _states.clear()
    worn.forget()


def _state(obj):
    return _states.setdefault(compat.session_key(obj), _State())


def followers(obj, taken):
    """[(Follower, its objects)] of a mesh, made anew where anything is another; what cannot be read is left out. taken:
    as of worn.taken(). @throws MeanValueError."""
    state, carrier, kinds = _state(obj), _shape(obj), {}
    state.size, state.places, state.problems = bounding_box_diagonal(carrier.rest), {}, {}
    for line, other in taken:
        try:
            place = state.places[compat.session_key(other)] = worn.to_carrier(obj, other)
            kinds.setdefault(line.kind, []).append((other, _shape(other), place))
        except MeanValueError as error:
            state.problems[compat.session_key(other)] = str(error)
    found = []
    for kind, parts in kinds.items():
        others, shapes, places = zip(*parts, strict=True)
        known = state.followers.get(kind)
        is_same = known and known.key == [each.revision for each in (carrier, *shapes)]
        if not is_same or not all(map(_is_same_place, places, known.places, [state.size] * len(places))):
            state.followers.pop(kind, None)  # frees its memory first
            state.followers[kind] = Follower(carrier, kind, shapes, places, state.size)
        found.append((state.followers[kind], others))
    return found


def _is_same_place(place, other, size):
    reach = np.abs(place[:3, :3]).max()
    return bool((np.abs(place - other)[:3] <= SAME_PLACE * np.array([reach, reach, reach, size])).all())


def problems(obj):
    """Sentences on those that should go along and do not."""
    ticked, known = [other for line, other in worn.listed(obj) if line.is_taken], _state(obj).problems
    return [each for other in ticked if (each := worn.problem(obj, other) or known.get(compat.session_key(other)))]


def is_behind(obj, shape):
    """Whether anything that goes along does not show the pose, n x 3 `shape` as it was handed to pose() last."""
    taken = worn.taken(obj)
    return bool(taken) and not _is_shown(obj, taken, shape)


def _is_shown(obj, taken, shape):
    state = _state(obj)
    if state.of is not shape or state.stamp != _stamp(taken):
        return False
    places = ((worn.to_carrier(obj, each), state.places.get(compat.session_key(each))) for _, each in taken)
    return all(known is None or _is_same_place(place, known, state.size) for place, known in places)


def _stamp(taken):
    """Another one where an object may be another, or can be written by now: each may carry others."""
    models = [(line.kind, other, object_model.of(other, READING)) for line, other in taken]
    return [(kind, model.stamp(other), subject.mode_problem(other)) for kind, other, model in models]


def pose(obj, shape, makes_keys=True):
    """The mesh has the pose n x 3 `shape` now: so has all that goes along, which may need keys that are not there."""
    taken = worn.taken(obj)
    if not taken or _is_shown(obj, taken, shape):
        return
    state, found, why, now, stamp = _state(obj), {}, "", time.monotonic(), _stamp(taken)
    compares = stamp != state.stamp or now > state.at + PAUSE_SECONDS
    try:
        for follower, others in followers(obj, taken):
            found.update(zip(others, follower.follow(shape), strict=True))
    except MeanValueError as error:
        why = str(error)
    state.of, state.stamp, state.at = shape, stamp, now
    for _, other in taken:
        key = compat.session_key(other)
        problem = why or state.problems.get(key) or subject.mode_problem(other)
        if problem:
            state.problems[key] = problem
        elif makes_keys or shape_keys.result(other):
            _write(obj, other, found[other], compares)
        else:
            state.of = None


def _write(obj, other, shape, compares):
    model, by = object_model.of(other, READING), shape_keys.result(obj)
    if compares:
        model.compare(other)
    key = shape_keys.result(other)
    if key is None or model.written is None:
        if key is None:
            other.meanvalue.result_name = by.name
        else:
            shape_keys.keep_edit(other, shape_keys.positions(key), model.overwritten)
        shape_keys.ensure_result_key(other)
        key = shape_keys.result(other)
    drive(key, by)  # which may be another one
    if not np.array_equal(model.written, shape):  # else it is not evaluated again
        shape_keys.write_positions(other.data, key, shape)
        model.wrote(shape)


def drive(key, by):
    """The value of a key is that of the mesh's, 0 where it is muted."""
    if actions.source_of(key) != (by.id_data, by.path_from_id("value")):
        key.driver_remove("value")
        actions.drive(key, {"value": by, "mute": by}, "value*(1-mute)")


def write_result(obj, shape):
    """The result of an operator, for the mesh and all that goes along. Returns notes."""
    notes = shape_keys.write_result(obj, shape)
    pose(obj, shape)
    return [*notes, *problems(obj)]


def group(obj):
    """The mesh and what goes along."""
    return [obj, *(other for _, other in worn.taken(obj))]


def keys_of(obj, key):
    """[(object, its key)]: of the mesh, and those of what goes along that this key drives."""
    path, found = (key.id_data, key.path_from_id("value")), [(obj, key)]
    for other in group(obj)[1:]:
        keys = other.data.shape_keys
        found += [(other, each) for each in (keys.key_blocks if keys else ()) if actions.source_of(each) == path]
    return found


def keep(obj, key):
    """The pose is kept as `key`: in all that goes along as a key of the same name, which that drives."""
    for other in group(obj)[1:]:
        shape = shape_keys.result_positions(other)
        if shape is not None:
            made = shape_keys.add_shape(other, key.name, shape)
            made.slider_min = key_marks.mark(Role.KEPT, made.name)
            drive(made, key)


def remove_pose(*objects):
    """Takes their result keys away, with the Basis if that was made for them."""
    for each in objects:
        shape_keys.remove(each, key_marks.pose_names(each))


def release(obj):
    """The mesh takes nothing along any more, and none of them has a result key."""
    for each in group(obj):
        for name in ("result_name", "result_mark"):
            each.meanvalue.property_unset(name)
    listed = [line.object for line in obj.meanvalue.along if line.object is not None]
    obj.meanvalue.along.clear()
    forget()
    for each in listed:
        remove_bare(each)
