# SPDX-License-Identifier: GPL-3.0-or-later
"""Live posing of one object: the newest targets win, and the last word is always a converged answer.

One job at a time runs beside the interface. What comes in meanwhile replaces what is wanted and never queues up. When
nothing has changed for a moment, the answer is settled: solved from where it is and from rest, and the better one kept,
so that it does not depend on the way the controls took.
"""

import contextlib

import numpy as np

from .. import compat, session
from ..bridge import bound_record, mesh_arrays, object_status, overlay_data, scene_input, shape_keys, targets
from ..core import result, wording
from ..errors import CancelledError, MeanValueError, SceneError
from ..workers.job import Job
from .live_targets import LiveTargets
from .scene_watch import QUIET_SECONDS, SceneWatch, clock

#: How long a handler waits for a solve, so that a quick one is drawn with the move that caused it.
FRAME_SECONDS = 1.0 / 30.0

#: Shapes closer than this, as a share of the bounding-box diagonal, are the same for the eye and for the solver
#: (its own tolerance is 1e-4): a shape that was reopened or undone is not written again.
SAME_SHAPE = 2e-4

#: Targets closer than this are the same: noise of float32 matrices.
SAME_TARGETS = 1e-6

#: How often a running job is looked at. A look takes 0.03 ms.
TICK_SECONDS = 0.001

#: How long the scene is read at a time.
SLICE_SECONDS = 0.01

#: Blender keeps a copy of its own of the mesh in these modes.
BUSY_MODES = {'EDIT', 'SCULPT'}


def identity(obj):
    """Tells an object with its mesh apart from all others while the file is open, whatever they are called."""
    return compat.session_key(obj), compat.session_key(obj.data) if obj.data else None


class Follower:
    """Use on the main thread only. `problem` says in words why the mesh does not follow, or is None.

    hears_itself  whether Blender calls edited() for what tick() writes, as its interface does. What is written in
                  its own handlers, by follow(), it evaluates without telling.
    """

    def __init__(self, obj, hears_itself):
        self.name = obj.name
        self.problem = None
        self.solve_seconds = 0.0
        self._hears_itself = hears_itself
        self._may_make_key = True
        self._scene = SceneWatch()
        self._job = None
        self.look_again()

    def look_again(self):
        """The scene may be another one by now (undo, edit): take nothing for granted but what is read again."""
        self.stop()
        self.problem = None
        self._scene.forget()
        self._targets = LiveTargets()
        self._nothing_known()

    def _nothing_known(self):
        self._binding = None
        self._wanted = None  # Targets: where the anchors should be
        self._shown = None  # k x 3: where they were for the solution that the mesh shows
        self._solution = None  # n x 3 float64
        self._written = None  # n x 3 float32: what is in the result key
        self._failed = None  # Targets that could not be reached
        self._is_settled = True
        self._changed_at = clock()

    def stop(self):
        """Cancels what is running; its result is dropped."""
        if self._job is not None:
            self._job.drop()
        self._job = self._collect = None
        self._is_settling = False

    def edited(self, obj):
        """Blender updated the object. Returns whether that was only what we wrote ourselves."""
        is_echo = self._scene.edited(obj)
        if not is_echo:
            self._targets.rig_moved()
            self._changed_at = clock()
        return is_echo

    def give_way(self, other_name):
        """Another object with the same mesh is live."""
        self.give_up(
            f"'{other_name}' has the same mesh and is live too. Turn Live off for one of them, or make the mesh a "
            "single user (Object > Relations > Make Single User)"
        )
        self._scene.waits_for_edit = False

    def give_up(self, problem):
        self.look_again()
        self.problem = problem
        self._scene.waits_for_edit = True

    def follow(self, obj):
        """Takes the controls where they are now, and waits at most a frame for the mesh to follow."""
        with self._telling_problems(), self._in_a_handler():
            if self._look(obj, SLICE_SECONDS):
                self._start_what_is_next(obj, FRAME_SECONDS if self.solve_seconds < FRAME_SECONDS else 0.0)

    def tick(self, obj):
        """Collects what is finished and starts what is next. Returns seconds until the next call, None for never."""
        with self._telling_problems():
            if self._scene.must_read:
                self._look(obj, SLICE_SECONDS)
            elif self._scene.must_check:
                self._check(obj)
            if not self._scene.must_read:
                self._catch_up_with_rig(obj)
                self._start_what_is_next(obj, 0.0)
        if self._scene.is_reading:
            return TICK_SECONDS
        if self._job is not None:
            return TICK_SECONDS if self.problem is None else QUIET_SECONDS
        is_done = self._is_shown() and self._is_settled and not self._targets.is_outdated
        if self.problem is None and (self._scene.must_check or not is_done):
            return max(TICK_SECONDS, self._changed_at + QUIET_SECONDS - clock())
        return None

    def _catch_up_with_rig(self, obj):
        """Once all is quiet: controls stand where the rig has carried their handles."""
        if self._targets.is_outdated and self._is_quiet() and self.problem is None and self._wanted is not None:
            self._targets.catch_up(obj, self._scene.bind_input)
            self._expect_echo()
            self._look(obj, SLICE_SECONDS)

    def _check(self, obj):
        """Once all is quiet: whether an echo has hidden an edit. Whatever happens meanwhile comes first."""
        if self._job is not None or not (self._is_shown() and self._is_settled):
            self._scene.stop_reading()
            return
        self._scene.must_read = True
        if self._read_on(obj, SLICE_SECONDS):
            if self._wanted is None:  # it has, and nobody else knows
                object_status.mark_edited(obj)
                overlay_data.mark_edited(obj)
            self._look(obj, SLICE_SECONDS)
        else:
            self._scene.must_read = False  # nothing has to wait for it

    def finish(self, obj):
        """Goes on until the mesh shows the settled answer. For the background, where nothing ticks."""
        with self._telling_problems():
            self._look(obj, np.inf)
            self._changed_at = -np.inf  # no need to wait for quiet
            self._catch_up_with_rig(obj)
        while self.problem is None and (self._job is not None or not (self._is_shown() and self._is_settled)):
            if self._job is not None:
                self._job.wait()
            self._changed_at = -np.inf  # no need to wait for quiet
            self.tick(obj)

    def is_settled(self, obj):
        """Whether the mesh shows the settled answer to where the controls are now."""
        with self._telling_problems():
            self._look(obj, np.inf)
        return self.problem is not None or (self._job is None and self._is_shown() and self._is_settled)

    @contextlib.contextmanager
    def _in_a_handler(self):
        hears_itself, self._hears_itself = self._hears_itself, False
        try:
            yield
        finally:
            self._hears_itself = hears_itself

    @contextlib.contextmanager
    def _telling_problems(self):
        """What cannot be bound waits for an edit; where the controls are is tried again whenever they move."""
        try:
            yield
        except CancelledError:
            pass
        except MeanValueError as error:
            if self._scene.must_read:
                self.give_up(str(error))
            else:
                self.problem = str(error)

    def _look(self, obj, patience):
        """Reads what has changed, for about so many seconds. Returns whether there are new targets.

        @throws MeanValueError.
        """
        self._scene.notice_settings(obj)
        if self._scene.waits_for_edit:
            return False
        if obj.mode in BUSY_MODES or obj.data.is_editmode:
            mode = scene_input.mode_name('EDIT' if obj.data.is_editmode else obj.mode)
            self._scene.must_read = True
            self._scene.stop_reading()
            raise SceneError(f"'{obj.name}' is in {mode}. It follows when you leave that")
        if self._scene.must_read and not self._read_on(obj, patience):
            return False
        goal = self._targets.gather(obj, self._scene.bind_input)
        same = SAME_TARGETS * self._scene.bind_input.diagonal
        if self._wanted is not None and goal.is_near(self._wanted, same):
            if self._is_shown() and self._failed is not self._wanted:
                self.problem = None
            return False
        self.problem = None
        self._mute(obj, goal.pose_key)
        self._wanted = goal
        self._is_settled = False
        self._changed_at = clock()
        return True

    def _start_what_is_next(self, obj, patience):
        self._collect_finished(obj)
        if self._job is None:
            self._start_next(obj)
            if self._job is not None and patience and self._job.wait(patience):
                self._collect_finished(obj)

    @property
    def is_caught_up(self):
        """Whether the mesh shows where the controls are, or something is in the way."""
        is_read = self._binding is not None and not self._scene.must_read
        return self.problem is not None or (is_read and self._is_shown())

    @property
    def is_working(self):
        return self._job is not None or self._scene.is_reading

    @property
    def is_reading(self):
        """Whether it has to read the mesh before anything else."""
        return self._scene.must_read and self._scene.is_reading

    def why_hidden(self, obj):
        """Why what it writes is not to be seen, in words, or None."""
        return shape_keys.why_result_is_hidden(obj)

    @property
    def text(self):
        """For the panel."""
        if self.is_reading:
            return "Live: reading the mesh"
        if self.problem:
            return wording.sentence(f"Live is waiting: {self.problem}")
        if self._binding is None and self._job is not None:
            stage, share = self._job.progress
            return f"Live: binding, {wording.stage(stage)}, {share:.0%}"
        if not self._is_shown():
            return "Live: solving"
        speed = f"Live: {wording.seconds(self.solve_seconds)} a solve" if self.solve_seconds else "Live"
        return " ".join(wording.sentence(each) for each in (speed, *self._notes())) if self._binding else speed

    def _read_on(self, obj, patience):
        """Reads the scene for about so many seconds. Returns whether all is read. @throws MeanValueError."""
        known = self._scene.bind_input
        if not self._scene.is_reading:
            self._require_result_key(obj)
            self._scene.start_reading(obj)
        if not self._scene.read_on(obj, patience):
            return False
        if known is None or known.fingerprint != self._scene.bind_input.fingerprint:
            self.stop()
            self._nothing_known()
            self._binding = session.cached(self._scene.bind_input)
        elif self._written is not None and not np.array_equal(shape_keys.result_positions(obj), self._written):
            self.stop()
            self._shown = self._solution = self._written = None
            self._is_settled = False
        return True

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

    def _notes(self):
        """What the artist may not expect of a result, in sentences."""
        yield from self._binding.summary.notes()
        if self._wanted is not None:
            yield from result.torn_notes(self._scene.bind_input, self._wanted.positions)

    def _is_quiet(self):
        return clock() >= self._changed_at + QUIET_SECONDS

    def _is_shown(self):
        return self._wanted is None or self._shown is self._wanted

    def _near(self, first, second, share):
        return bool(np.abs(first - second).max(initial=0.0) <= share * self._scene.bind_input.diagonal)

    def _start_next(self, obj):
        if self._wanted is None:
            return
        if self._binding is None:
            self._start_bind(obj)
        elif not self._is_shown():
            self._start_solve(obj)
        elif not self._is_settled and self._is_quiet():
            self._start_settle(obj)

    def _start_bind(self, obj):
        bind_input = self._scene.bind_input
        known = session.earlier(bind_input)
        triangles = mesh_arrays.triangles(obj.data, bind_input.rest) if known is None else None

        def work(execution):
            return session.bind_steps(bind_input, triangles, execution, known=known)

        self._start(work, self._collect_binding)

    def _start_solve(self, obj):
        binding, bind_input, wanted = self._binding, self._scene.bind_input, self._wanted
        start, is_first = self._solution, self._solution is None
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
            self.problem = None
            if is_first and start is not None and self._near(solved, start, SAME_SHAPE):
                self._written = shape_keys.result_positions(owner)
            else:
                self._write(owner, composed)

        self._start(work, collect)

    def _start_settle(self, obj):
        binding, bind_input, wanted, start = self._binding, self._scene.bind_input, self._wanted, self._solution

        def work(execution):
            settled, _summary = yield from session.solve_steps(
                binding, bind_input, wanted, start, settle=True, execution=execution
            )
            return settled, result.compose(bind_input, wanted.positions, settled)

        def collect(owner, outcome):
            settled, composed = outcome
            self._is_settled = self._wanted is wanted
            if self._is_settled and not self._near(settled, start, SAME_TARGETS):
                self._solution = settled
                self._write(owner, composed)

        self._start(work, collect)
        self._is_settling = True

    def _start(self, work, collect):
        self._job = Job(work)
        self._collect = collect

    def _collect_finished(self, obj):
        if self._job is None:
            return
        if self._is_settling and not self._is_shown():
            self._job.cancel()
        if not self._job.is_finished:
            return
        job, collect = self._job, self._collect
        self._job = self._collect = None
        self._is_settling = False
        try:
            outcome = job.result()
        except CancelledError:
            raise
        except MeanValueError as error:
            if self._binding is None:
                self.give_up(str(error))  # the same input would fail again
                return
            self._failed = self._shown = self._wanted  # not again for the same targets
            self._is_settled = True
            raise
        collect(obj, outcome)

    def _collect_binding(self, obj, binding):
        self._binding = binding
        session.remember(self._scene.bind_input, binding)
        bound_record.write(obj.meanvalue.bound, self._scene.bind_input.fingerprint, binding.summary)

    def _mute(self, obj, pose_key):
        """The key that anchors were moved in must not be added to the result."""
        if pose_key and pose_key != obj.meanvalue.result_key:
            key = obj.data.shape_keys.key_blocks[pose_key]
            if not key.mute:
                key.mute = True
                self._expect_echo()

    def _write(self, obj, composed):
        key = obj.data.shape_keys.key_blocks.get(obj.meanvalue.result_key) if obj.data.shape_keys else None
        is_busy = obj.mode in BUSY_MODES or obj.data.is_editmode
        if is_busy or key is None or not (len(obj.data.vertices) == len(key.data) == len(composed)):
            self._scene.must_read = True
            return
        self._written = composed
        shape_keys.write_positions(obj.data, key, self._written)
        self._expect_echo()

    def _expect_echo(self):
        if self._hears_itself:
            self._scene.wrote()
