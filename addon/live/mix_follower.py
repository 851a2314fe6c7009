# SPDX-License-Identifier: GPL-3.0-or-later
"""Live mixing of one object's shape keys: a key of our own adds what Blender's straight lines lack.

The sliders are Blender's. Where they are now is what is wanted; one job at a time runs beside the interface, and the
newest values win. While sliders move it shows drafts; once they are quiet the mix that depends on their values alone.
Shapes are read again once all is quiet, since Blender tells of a slider as it does of an edit.
"""

import contextlib

import numpy as np

from .. import mix_session
from ..bridge import mix_layers, scene_input
from ..core import wording
from ..errors import CancelledError, MeanValueError, SceneError
from ..workers.job import Job
from .scene_watch import QUIET_SECONDS, clock

#: As of live posing (follower.py): how long a handler waits, how often a job is looked at, how long is read at a time.
FRAME_SECONDS = 1.0 / 30.0
TICK_SECONDS = 0.001
SLICE_SECONDS = 0.01


class MixFollower:
    """Called by live/engine.py as live/follower.py's Follower is, on the main thread only."""

    def __init__(self, obj, hears_itself):
        self.name = obj.name
        self.problem = None
        self.solve_seconds = 0.0
        self._hears_itself = hears_itself
        self._job = None
        self.look_again()

    def look_again(self):
        self.stop()
        self.problem = None
        self._input = self._morpher = self._reading = self._signature = None
        self._wanted = self._shown = None
        self._shows_draft = self._is_finishing = False
        self._must_read, self._must_check, self._expects_echo = True, False, False
        self._waits_for_edit = self._is_written = False
        self._changed_at = clock()

    def stop(self):
        if self._job is not None:
            self._job.drop()
        self._job = self._collect = None
        self._is_settling = False

    def edited(self, obj):
        """Returns whether Blender's update was only what we wrote ourselves."""
        is_echo, self._expects_echo = self._expects_echo, False
        self._must_check = True
        self._waits_for_edit = False
        self._reading = None if not self._must_read else self._reading
        return is_echo and self._signature == mix_layers.signature(obj)

    def give_way(self, other_name):
        self.give_up(
            f"'{other_name}' has the same mesh and shapes it too. Turn Rotation-Aware Keys, or Live, off for one of "
            "them, or make the mesh a single user (Object > Relations > Make Single User)"
        )
        self._waits_for_edit = False

    def give_up(self, problem):
        self.look_again()
        self.problem = problem
        self._waits_for_edit = True

    def follow(self, obj):
        """Takes the sliders where they are now, and waits at most a frame for the mesh."""
        with self._telling_problems():
            hears_itself, self._hears_itself = self._hears_itself, False
            try:
                self._go_on(obj, FRAME_SECONDS if self.solve_seconds < FRAME_SECONDS else 0.0)
            finally:
                self._hears_itself = hears_itself

    def tick(self, obj):
        """Returns seconds until the next call, None for never."""
        with self._telling_problems():
            self._go_on(obj, 0.0)
        if self._job is not None or self._reading is not None:
            return TICK_SECONDS
        if self.problem is None and (self._must_check or self._shows_draft):
            return max(TICK_SECONDS, self._changed_at + QUIET_SECONDS - clock())
        return None

    def finish(self, obj):
        """Goes on until the mesh shows the mix. For the background, where nothing ticks."""
        self._is_finishing = True
        try:
            with self._telling_problems():
                self._take_input(obj, mix_layers.gather(obj))
                self._go_on(obj, 0.0)
            while self.problem is None and self._job is not None:
                self._job.wait()
                with self._telling_problems():
                    self._start_what_is_next(obj, 0.0)
        finally:
            self._is_finishing = False

    def is_settled(self, _obj):
        """It has no say in the pose."""
        return True

    @property
    def is_caught_up(self):
        if self.problem is not None:
            return True
        return self._job is None and self._shown is not None and self._is_shown() and not self._shows_draft

    @property
    def is_working(self):
        return self._job is not None or self._reading is not None

    @property
    def is_reading(self):
        return self._must_read and self._reading is not None

    @property
    def text(self):
        """For the panel."""
        if self.problem:
            return wording.sentence(f"Mixing is waiting: {self.problem}")
        if self._must_read:
            return "Mixing: reading the shape keys"
        if self._morpher is None:
            stage, share = self._job.progress if self._job is not None else ("", 0.0)
            return f"Mixing: binding, {wording.stage(stage)}, {share:.0%}"
        return f"Mixing: {wording.seconds(self.solve_seconds)} a solve." if self.solve_seconds else "Mixing"

    def why_hidden(self, obj):
        return mix_layers.why_hidden(obj)

    def _go_on(self, obj, patience):
        self._require_ready(obj)
        if self._waits_for_edit:
            return
        if self._signature != mix_layers.signature(obj):
            self._must_read, self._reading = True, None
        if not self._must_read:
            self._look_at_sliders(obj)
        is_idle = self._job is None and self._is_shown() and self._is_quiet()
        if self._must_read or self._reading is not None or (self._must_check and is_idle):
            self._read_on(obj)
        if not self._must_read:
            self._look_at_sliders(obj)
            self._start_what_is_next(obj, patience)

    def _require_ready(self, obj):
        if obj.mode != 'OBJECT' or obj.data.is_editmode:
            mode = scene_input.mode_name('EDIT' if obj.data.is_editmode else obj.mode)
            self._must_check = True
            raise SceneError(f"'{obj.name}' is in {mode}. It goes on when you leave that")
        if obj.meanvalue.baked.target:
            raise SceneError("A bake plays in place of the mix. Press Remove Bake to mix live, or bake it anew")
        if mix_layers.made_names(obj):
            raise SceneError(
                "In-between keys stand for the mix already. Press Remove In-Betweens to mix live, or turn "
                "Rotation-Aware Keys off"
            )

    def _read_on(self, obj):
        if self._reading is None:
            self._signature = mix_layers.signature(obj)
            self._reading = mix_layers.MixReading(obj)
        if self._reading.go_on(obj, SLICE_SECONDS):
            reading, self._reading = self._reading, None
            self._take_input(obj, reading.result(obj))

    def _take_input(self, obj, mix_input):
        self._signature = mix_layers.signature(obj)
        former, self._input = self._input, mix_input
        self._must_read = self._must_check = False
        if former is not None and former.revision == mix_input.revision:
            return
        self.stop()
        self._shown = self._wanted = None
        self._shows_draft = False
        self._morpher = mix_session.cached(mix_input)

    def _look_at_sliders(self, obj):
        now = mix_layers.values(obj)
        if self._wanted is None or not np.array_equal(now, self._wanted):
            self._wanted = now
            self._changed_at = clock()
            if self._is_settling:
                self.stop()
        if self._is_written and not mix_layers.has_key(obj):
            self._is_written, self._shown = False, None
        self.problem = None

    def _is_quiet(self):
        return self._is_finishing or clock() >= self._changed_at + QUIET_SECONDS

    def _is_shown(self):
        return self._wanted is None or self._shown is self._wanted

    def _start_what_is_next(self, obj, patience):
        self._collect_finished(obj)
        if self._job is None and self._morpher is None:
            self._start_bind()
        if self._job is None and self._morpher is not None and self._wanted is not None:
            is_quiet = self._is_quiet()
            if not self._is_shown() or (self._shows_draft and is_quiet):
                self._start_solve(is_draft=not is_quiet)
        if self._job is not None and patience and self._job.wait(patience):
            self._collect_finished(obj)

    def _start_bind(self):
        mix_input = self._input

        def collect(_obj, morpher):
            mix_session.remember(mix_input, morpher)
            self._morpher = morpher

        self._job = Job(lambda execution: mix_session.bind_steps(mix_input, execution))
        self._collect = collect

    def _start_solve(self, is_draft):
        morpher, mix_input, wanted = self._morpher, self._input, self._wanted

        def work(execution):
            mix = yield from mix_session.solve_steps(morpher, mix_input, wanted, execution, is_draft)
            correction = mix.positions - mix_input.linear(wanted)
            return (mix_input.rest + correction).astype(np.float32), mix.seconds

        def collect(obj, outcome):
            shape, seconds = outcome
            if is_draft or not self.solve_seconds:
                self.solve_seconds = seconds  # what a frame of a drag takes
            self._shown, self._shows_draft = wanted, is_draft
            mix_layers.write(obj, shape)
            self._is_written = True
            self._expects_echo = self._hears_itself

        self._job = Job(work)
        self._collect = collect
        self._is_settling = not is_draft

    def _collect_finished(self, obj):
        if self._job is None or not self._job.is_finished:
            return
        job, collect = self._job, self._collect
        self._job = self._collect = None
        self._is_settling = False
        try:
            outcome = job.result()
        except CancelledError:
            raise
        except MeanValueError:
            self._shown, self._shows_draft = self._wanted, False  # not again for the same sliders
            if self._morpher is None:
                self._waits_for_edit = True
            raise
        collect(obj, outcome)

    @contextlib.contextmanager
    def _telling_problems(self):
        try:
            yield
        except CancelledError:
            pass
        except MeanValueError as error:
            self._reading = None
            self.problem = str(error)
