# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether the handles of an object drive its shape keys, which then are rooms.ShownKeys; Live then; what they do not
reach, as one more shape key."""

import dataclasses
import time
from functools import cached_property

import numpy as np

from ... import ids
from ...errors import ChangedMeanwhileError, SceneError, require_none
from ...posing.bridge import scene_input, targets
from ...posing.core.bind_input import BindInput
from ...posing.live.follower import Follower
from ...scene import actions, key_marks, mesh_arrays, object_model, shape_keys, vertex_groups
from ...scene.core import welding
from ...scene.core.key_shapes import KeyShapes
from ...scene.key_marks import Role
from ...solver import session
from . import key_shapes

SHAPE, KEYS = 'SHAPE', 'SHAPE_KEYS'


def is_on(obj):
    return obj.meanvalue.drive == KEYS


def problem(obj):
    return None if is_on(obj) else "Handles drive no shape keys. Choose Shape Keys in Drive"


def names(obj):
    if not is_on(obj):
        return []
    driven = [slider.name for slider in key_shapes.sorted_out(obj)[0]]
    corrective = key_marks.only(obj.data.shape_keys, Role.CORRECTIVE)
    return driven if corrective is None else [*driven, corrective.name]


def positions(obj):
    if not is_on(obj):
        return None
    try:
        shapes = key_shapes.gather(obj)
    except SceneError:  # told where they are to be driven
        return None
    return shapes.mixed(key_shapes.values(obj, shapes.names)).astype(np.float32)


def keyframe(obj):
    if not is_on(obj):
        return None
    require_none(key_shapes.problem(obj))
    driven = names(obj)
    for name in driven:
        actions.insert_key(obj.data.shape_keys.key_blocks[name], "value")
    return len(driven), "shape key"


def chosen(obj):
    """Drive was chosen. The result, which posing by its shape writes, is not to be added to what keys show."""
    result = shape_keys.result(obj)
    if result is not None and result != obj.data.shape_keys.reference_key:
        key_marks.show(result, None if is_on(obj) else 1.0)
    obj.update_tag()


#: Of the mesh's size: what moves no vertex by more is no corrective.
NOTHING = 1e-5


class Corrective(scene_input.Posing):
    """Poses the mix of the sliders by the handles. Pose Like has no say: the mix is what the mesh is to look like."""

    binding = _known = _start = None

    def __init__(self, obj):
        """@throws SceneError."""
        self._held = scene_input.gather(obj, to_bind=False)
        self.targets = targets.gather(obj, self._held)
        shapes = key_shapes.gather(obj)
        mix = shapes.mixed(key_shapes.values(obj, shapes.names)).astype(np.float32)
        copies = welding.together(self._held.copies, [mix], obj.meanvalue.merge_distance)
        self.bind_input = dataclasses.replace(self._held, rest=mix, copies=copies)
        self.bind_input.check()
        self._triangles = mesh_arrays.triangles(obj.data, mix)

    def require_unchanged(self, obj):
        """@throws ChangedMeanwhileError if handles, keys or their values are others by now."""
        now = Corrective(obj)
        is_same = now.bind_input.fingerprint == self.bind_input.fingerprint and now.targets.is_near(self.targets, 0.0)
        if not is_same or now._held.fingerprint != self._held.fingerprint:
            raise ChangedMeanwhileError(obj.name)

    def write(self, obj, shape):
        """The name of the key, shown fully, which is relative to the rest shape. @throws SceneError."""
        offset = shape - self.bind_input.rest
        if np.abs(offset).max(initial=0.0) <= NOTHING * self._held.diagonal:
            raise SceneError("The shape keys reach all handles, so there is nothing left for a corrective")
        last, shape = key_marks.only(obj.data.shape_keys, Role.CORRECTIVE), self._held.rest + offset
        return shape_keys.write_only(obj, Role.CORRECTIVE, last, ids.CORRECTIVE_KEY, shape).name


@dataclasses.dataclass(frozen=True, eq=False)
class DriveInput:
    """What handles hold, and the shape keys that they drive. Each handle counts the same, however many vertices it has.
    On a symmetric mesh, their mirror images are held as well."""

    bind_input: BindInput
    shapes: KeyShapes

    @property
    def revision(self):
        return self.bind_input.revision, self.shapes.revision

    @property
    def diagonal(self):
        return self.bind_input.diagonal

    @cached_property
    def _own(self):
        """Which anchors of what goes to the solver are vertices of the mesh: those of handles, and their images."""
        mesh = self.bind_input.solver_mesh
        return np.flatnonzero(np.isin(mesh.anchors, mesh.places))

    @property
    def anchors(self):
        """K vertex indices."""
        mesh = self.bind_input.solver_mesh
        return mesh.values(np.arange(len(self.bind_input.rest)))[mesh.anchors[self._own]]

    @property
    def handles(self):
        """K: number of the handle that each anchor, or what it mirrors, belongs to."""
        return self.bind_input.solver_mesh.owners[self._own]

    @cached_property
    def _counts(self):
        """(K bool: which are no images, how many of these each handle has): a handle counts as much without images."""
        mesh = self.bind_input.solver_mesh
        is_held = np.isin(mesh.anchors[self._own], mesh.places[self.bind_input.anchors])
        return is_held, np.maximum(np.bincount(self.handles, is_held), 1.0)

    def targets(self, positions):
        """(..., K, 3) targets of all anchors, made of those of the handles' anchors, (..., k, 3)."""
        return self.bind_input.solver_mesh.targets(positions)[..., self._own, :]

    def weights(self, counts=None):
        """(..., K): how much each counts; counts: (..., k), from 0 to 1, of the handles' anchors, None for all."""
        weights, counts = 1.0 / self._counts[1][self.handles], self.bind_input.solver_mesh.weights(counts)
        return weights if counts is None else weights * counts[..., self._own]

    def farthest(self, residuals):
        """(number of the handle, distance): the handle that is missed the most, by the mean of (K, 3) residuals."""
        is_held, counts = self._counts
        means = np.bincount(self.handles, np.linalg.norm(residuals, axis=1) * is_held) / counts
        return int(means.argmax()), float(means.max())


REFUSED = "The shape keys cannot be driven by these handles: {}"

#: Of the mesh's size: handles that are missed by more are told of.
OUT_OF_REACH = 0.01


#: Of DriveInputs; sliders alone are written.
READING = object_model.Kind(
    lambda obj: (scene_input.signature(obj), len(obj.data.vertices), key_shapes.sorted_out(obj)),
    lambda obj: DriveInput(scene_input.read(obj, to_bind=False), key_shapes.gather(obj)),
    lambda found: vertex_groups.key_shapes(found.shapes),
    lambda _obj: "",
)


class KeyFollower(Follower):
    """The sliders go to where the keys are nearest to the handles: a function of where the controls are alone. So they
    change steadily in a drag, and are settled at once. What is bound is a native SliderFit."""

    READS = READING
    READS_AT_REST = True
    asks_for = staticmethod(lambda obj: obj.meanvalue.live and is_on(obj))

    @staticmethod
    def why_hidden(obj):
        if obj.show_only_shape_key:
            return "A shape key is pinned. Turn off Shape Key Lock to see what the handles drive"
        if obj.meanvalue.baked.target:
            return shape_keys.BAKE_PLAYS
        result = shape_keys.result(obj)
        if result is None or result.mute or result.value == 0.0:
            return None
        return f"Shape key '{result.name}' shows a pose of its own on top of the keys that are driven. Mute it"

    def notes(self):
        if self._missed is not None:
            yield f"The shape keys do not reach as far as '{self._missed}'"
        note = key_shapes.left_alone_note(self._input.shapes.left_alone)
        if note:
            yield note

    def _begin_anew(self):
        super()._begin_anew()
        self._missed = None  # name of the handle that the keys do not reach

    def _is_shown(self, _obj):
        return self._wanted is not None and self._shown is self._wanted

    def _read_targets(self, obj):
        return self._targets.gather(obj, self._input.bind_input, self._wanted)

    def _do_chores(self, obj):
        self._targets.catch_up(obj, self._input.bind_input)

    @staticmethod
    def _cached_binding(found):
        """Made at once, since it takes no longer than to look it up. @throws SolverError."""
        return key_shapes.fit(found.shapes, found.shapes.fit_input(found.anchors), REFUSED, can_move=False)

    def _solve_work(self, _obj, **_options):
        fit, drive, wanted = self._binding, self._input, self._wanted
        names = drive.shapes.names

        def collect(obj, found):
            self._shown, self._is_settled = wanted, wanted is self._wanted
            number, distance = drive.farthest(found.residuals)
            handle = targets.enabled_handles(obj)[number]
            self._missed = handle.name if distance > OUT_OF_REACH * drive.diagonal else None
            key_shapes.set_values(obj, names, found.values)

        def work(_execution):
            begun = time.perf_counter()
            found = yield from session.steps(
                fit.start_solve,
                drive.targets(wanted.positions),
                drive.weights(wanted.weights),
                steady=True,
                refused=REFUSED,
            )
            self.solve_seconds = time.perf_counter() - begun
            return found

        return work, collect
