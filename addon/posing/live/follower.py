# SPDX-License-Identifier: GPL-3.0-or-later
"""Live posing of one object by its handles."""

import numpy as np

from ... import compat
from ...errors import SceneError, StaleBindingError
from ...live import states
from ...live.following import Following
from ...live.states import NotReadyError
from ...scene import mesh_arrays, object_model, rig_space, shape_keys, subject
from ...solver import session
from ...solver.core import fingerprint, result
from ..bridge import bound_record, controls, scene_input, targets
from .live_targets import LiveTargets

#: Shapes closer than this, as a share of the bounding-box diagonal, are the same for the eye and for the solver
#: (its own tolerance is 1e-4): a shape that was reopened or undone is not written again.
SAME_SHAPE = 2e-4

#: Targets closer than this are the same: noise of float32 matrices.
SAME_TARGETS = 1e-6

#: Blender keeps a copy of its own of the mesh in these modes.
BUSY_MODES = {'EDIT', 'SCULPT'}


class Follower(Following):
    """The newest targets win. The last word is solved from where it is and from rest, and the better one kept."""

    FOLLOWS = "controls"
    LABEL = "Live"

    @staticmethod
    def asks_for(obj):
        return obj.meanvalue.live

    @staticmethod
    def turn(obj, is_on):
        obj.meanvalue.live = is_on

    @staticmethod
    def places(obj, depsgraph):
        """Where the controls are in the object's space, as numbers to be compared."""
        world = obj.evaluated_get(depsgraph).matrix_world.inverted_safe()
        rigs = [modifier.object for modifier in obj.modifiers if modifier.type == 'ARMATURE']  # followed in renders
        found = []
        for handle in targets.enabled_handles(obj):
            control = handle.control
            if handle.follows != 'CONTROL' or controls.problem(obj, handle) is not None or control in rigs:
                continue
            evaluated = control.evaluated_get(depsgraph)
            place = world @ evaluated.matrix_world
            if control.type == 'ARMATURE' and handle.bone in evaluated.pose.bones:
                place = place @ evaluated.pose.bones[handle.bone].matrix
            found.append(np.array(place).ravel())
        return np.concatenate(found) if found else np.empty(0)

    def __init__(self, obj, hears_itself):
        self._may_make_key = True
        self._muted = ""  # the shape key that was muted last since anchors are moved in it
        super().__init__(obj, hears_itself)

    def _nothing_known(self):
        super()._nothing_known()
        self._nothing_shown()
        self._targets = LiveTargets()
        self._rig = None  # what the rig's revision was when it was looked at last

    def _nothing_shown(self):
        self._shown = self._settled = None
        self._solution = None  # n x 3 float64
        self._written = None  # n x 3 float32: what is in the result key

    def why_hidden(self, obj):
        """Why what it writes is not to be seen, in words, or None."""
        return shape_keys.why_result_is_hidden(obj)

    def _why_it_gives_way(self, other_name):
        return (
            f"'{other_name}' has the same mesh and is live too. Turn Live off for one of them, or make the mesh a "
            "single user (Object > Relations > Make Single User)"
        )

    def _notes(self):
        yield from self._binding.summary.notes()
        if self._wanted is None:
            return
        yield from result.torn_notes(self._input, self._wanted.positions)
        if self._muted and self._muted == self._wanted.pose_key:
            yield (
                f"'{self._muted}' is the active shape key, so it poses the anchors that follow one, and is muted so "
                "that it is not added to the result. To see it as it is, choose the key that poses them, and tick it "
                "in Object Data Properties"
            )

    # Reading

    def _must_read(self, _obj, model):
        return self._seen != model.stamp

    def _has_doubts(self, obj):
        return self._targets.is_behind(obj) or self._must_confirm(obj)

    def _must_confirm(self, obj):
        return not self._is_finishing and object_model.of(obj).is_doubtful

    def _require_ready(self, obj):
        rig, self._rig = self._rig, object_model.rig_revision(obj)
        if rig != self._rig:  # it may go on moving
            self._changed_at = states.clock()
        if obj.mode in BUSY_MODES or obj.data.is_editmode:
            mode = subject.mode_name('EDIT' if obj.data.is_editmode else obj.mode)
            raise NotReadyError(f"'{obj.name}' is in {mode}. It follows when you leave that")

    def _read_on(self, obj, seconds):
        self._require_result_key(obj)
        scene_input.require_handles(obj)
        return object_model.of(obj).read_on(obj, seconds)

    def _gather(self, obj):
        bind_input = object_model.of(obj).bind_input(obj)
        _require_good_binding(obj, bind_input)
        return bind_input

    def _is_same_input(self, first, second):
        return first is second or first.fingerprint == second.fingerprint

    def _cached_binding(self):
        return session.cached(self._input)

    def _require_shown(self, obj):
        """Somebody else may have written the result."""
        if self._written is not None and not np.array_equal(shape_keys.result_positions(obj), self._written):
            self.stop()
            self._nothing_shown()

    def _require_result_key(self, obj):
        may_make_key, self._may_make_key = self._may_make_key, False
        if shape_keys.result_positions(obj) is not None or shape_keys.result_problem(obj) is not None:
            return
        if may_make_key:
            targets.prepare_result(obj)
            return
        raise SceneError(
            f"the shape key '{obj.meanvalue.result_key}', which it writes, is missing. Turn Live off and on to make it"
        )

    def _start_check(self, obj):
        if self._targets.is_behind(obj):
            self._targets.catch_up(obj, self._input)
            if compat.tells_of_copies() and rig_space.is_there(obj):
                self._expect_echo(obj)
        if self._must_confirm(obj):
            object_model.of(obj).doubt()

    def _check_on(self, obj, seconds):
        if not self._must_confirm(obj):
            return True
        model = object_model.of(obj)
        if not model.read_on(obj, seconds):
            return False
        if not model.confirm(obj):  # else it is another one, and read from what was read just now
            self._seen = model.stamp
            self._require_shown(obj)
        return True

    # Posing

    def _read_targets(self, obj):
        return self._targets.gather(obj, self._input)

    def _is_same_target(self, first, second):
        return first.is_near(second, SAME_TARGETS * self._input.diagonal)

    def _bind_work(self, obj):
        bind_input = self._input
        known = session.earlier(bind_input)
        triangles = mesh_arrays.triangles(obj.data, bind_input.rest) if known is None else None
        return lambda execution: session.bind_steps(bind_input, triangles, execution, known=known)

    def _keep_binding(self, obj, binding):
        self._binding = binding
        session.remember(self._input, binding)
        bound_record.write(obj.meanvalue.bound, self._input.fingerprint, binding.summary)

    def _solving(self, obj):
        binding, bind_input, wanted = self._binding, self._input, self._wanted
        start, is_first = self._solution, self._solution is None
        self._mute(obj, wanted.pose_key)
        if is_first:
            shown = shape_keys.result_positions(obj).astype(np.float64)
            start = shown if result.all_finite(shown) else None

        def work(execution):
            solved, summary = yield from session.solve_steps(
                binding, bind_input, wanted, start=start, execution=execution
            )
            return solved, summary, result.compose(bind_input, wanted.positions, solved)

        def collect(owner, outcome):
            solved, summary, composed = outcome
            self.solve_seconds = summary.seconds
            self._solution, self._shown = solved, wanted
            if is_first and start is not None and self._near(solved, start, SAME_SHAPE):
                self._written = shape_keys.result_positions(owner)
            else:
                self._write(owner, composed)

        return work, collect

    def _settling(self, _obj):
        binding, bind_input, wanted, start = self._binding, self._input, self._wanted, self._solution

        def work(execution):
            settled, _summary = yield from session.solve_steps(
                binding, bind_input, wanted, start, settle=True, execution=execution
            )
            return settled, result.compose(bind_input, wanted.positions, settled)

        def collect(owner, outcome):
            settled, composed = outcome
            if self._wanted is not wanted:
                return
            self._settled = wanted
            if not self._near(settled, start, SAME_TARGETS):
                self._solution = settled
                self._write(owner, composed)

        return work, collect

    def _near(self, first, second, share):
        return bool(np.abs(first - second).max(initial=0.0) <= share * self._input.diagonal)

    def _mute(self, obj, pose_key):
        """The key that anchors were moved in must not be added to the result."""
        if pose_key and pose_key != obj.meanvalue.result_key:
            key = obj.data.shape_keys.key_blocks[pose_key]
            if not key.mute:
                key.mute = True
                self._muted = pose_key
                self._expect_echo(obj)

    def _write(self, obj, composed):
        key = obj.data.shape_keys.key_blocks.get(obj.meanvalue.result_key) if obj.data.shape_keys else None
        is_busy = obj.mode in BUSY_MODES or obj.data.is_editmode
        if is_busy or key is None or not (len(obj.data.vertices) == len(key.data) == len(composed)):
            self._seen = None  # it was edited: read all again
            return
        self._written = composed
        shape_keys.write_positions(obj.data, key, self._written)
        self._expect_echo(obj)


def _require_good_binding(obj, bind_input):
    bound = bound_record.read_fingerprint(obj.meanvalue.bound)
    if bound is None:
        return
    reasons = fingerprint.stale_reasons(bound, bind_input.fingerprint)
    if fingerprint.needs_bind(reasons):
        changes = fingerprint.describe(reasons, bound, bind_input.fingerprint)
        raise StaleBindingError(f"{changes}. Check the handles and press Bind")
