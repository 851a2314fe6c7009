# SPDX-License-Identifier: GPL-3.0-or-later
"""What following handles and following sliders have in common. What each has of its own: rooms.Follows.

One job at a time runs beside the interface. What comes in meanwhile replaces what is wanted. When nothing has changed
for a moment the answer is settled, so that it does not depend on the way there. What is to be done next follows from
what is known: what was read, its binding, what is wanted, and what is shown.
"""

import time

from .. import wording
from ..errors import CancelledError, MeanValueError, SceneError
from ..scene import kept, key_marks, object_model, shape_keys, subject
from ..solver.job import Job

#: How long a handler waits for a solve, so that a quick one is drawn with the move that caused it.
FRAME_SECONDS = 1.0 / 30.0

#: And where something else can be shown: evaluating the mesh once more takes about as long.
QUICK_SECONDS = 0.01

#: How often a running solve is looked at: it is noticed a tenth of a frame late. And what takes longer.
TICK_SECONDS, SLOW_TICK_SECONDS = 0.003, 0.02

#: How long all has to be quiet before the answer is settled, and keys are compared with what was written.
QUIET_SECONDS = 0.25

#: What takes longer is told of while it goes on.
SLOW_SECONDS = 1.0

clock = time.monotonic


class Following:
    """Use on the main thread only. Knows of the object only its name. problem: in words why it does not follow, or
    None; solve_seconds: of the last solve."""

    #: In these modes it waits: Blender keeps a copy of its own of the mesh.
    BUSY_MODES = {'EDIT', 'SCULPT'}

    #: Whether it is read again only when all is quiet: Blender tells of sliders as it does of edits.
    READS_AT_REST = False

    def __init__(self, obj):
        self.name = obj.name
        self._job = None
        self.solve_seconds = 0.0
        self.look_again()

    def look_again(self):
        """The scene may be another one by now (undo, edit): take nothing for granted but what is read again."""
        self.stop()
        self._input = None
        self._begin_anew()

    def _begin_anew(self):
        self.problem = None
        self._binding = None
        self._wanted = None  # where the controls are
        self._shown = None  # where they were for the answer that the mesh shows
        self._is_settled = False
        self._changed_at = clock()

    def stop(self):
        """Cancels what is running; its result is dropped."""
        if self._job is not None:
            self._job.drop()
        self._job = None

    def give_up(self, problem):
        """Until something changes."""
        self.stop()
        self._wanted = None
        self.problem = problem

    # What the engine calls

    def follow(self, obj):
        """In a handler: takes the controls where they are. Shows a draft, or waits a frame where there is none."""
        running = self._job
        self._advance(obj)
        is_new = self._job is not running  # none is waited for again
        if is_new:
            self._wait_for_job(obj, QUICK_SECONDS)
        is_waiting = self._job is not None and self.problem is None and not self._is_shown(obj)
        if is_waiting and not (self._has_key(obj) and self._show_meanwhile(obj)) and is_new:
            self._wait_for_job(obj, FRAME_SECONDS - QUICK_SECONDS)

    def tick(self, obj):
        """In a timer: collects what is finished, and starts what is next: also where the mesh is another meanwhile."""
        if self._job is None or self._job.is_finished or (self._binding is None and not self._is_read(obj)):
            self._advance(obj, makes_keys=True)
        elif self._binding is None:
            self._show_meanwhile(obj)

    def finish(self, obj):
        """Goes on until the mesh shows the settled answer. For the background, where nothing ticks."""
        self._advance(obj, makes_keys=True, is_quiet=True)
        while self.problem is None and self.wait(obj) is not None:
            if self._job is not None:
                self._job.wait()
            self._advance(obj, makes_keys=True, is_quiet=True)

    def is_settled(self, obj):
        """Whether the mesh shows the settled answer to where the controls are now; so too where it cannot follow."""
        self._advance(obj, is_quiet=True, starts=False)
        return self.problem is not None or (self._is_shown(obj) and self._is_settled)

    def is_behind(self, obj):
        """Whether the mesh does not show the settled answer, as far as is known, to where the controls were last."""
        return self.problem is None and not (self._is_shown(obj) and self._is_settled)

    def wait(self, obj):
        """Seconds until tick() is to be called, or None if there is nothing to do."""
        if self.problem is not None:
            return None
        if self._job is not None:
            return TICK_SECONDS if self._binding is not None else SLOW_TICK_SECONDS
        if not (self._is_shown(obj) and self._is_read(obj)):
            return TICK_SECONDS
        if self._is_settled and not self._model(obj).is_unchecked and not self._has_chores(obj):
            return None
        return max(TICK_SECONDS, self._quiet_at(obj) - clock())

    def status(self, obj):
        """(text, whether it is a problem) of what the artist has to know, or None."""
        if self.problem:
            return wording.sentence(f"Waiting: {self.problem}"), True
        if self._binding is None:
            if clock() < self._changed_at + SLOW_SECONDS:
                return None
            return f"Preparing: {self._job.progress[1] if self._job else 0.0:.0%}", False
        if not self._is_shown(obj):
            return ("Following...", False) if self.solve_seconds > SLOW_SECONDS else None
        notes = [wording.sentence(each) for each in self.notes()]
        return (" ".join(notes), False) if notes else None

    def _require_ready(self, obj):
        """@throws MeanValueError if nothing can follow now."""
        if obj.mode in self.BUSY_MODES or obj.data.is_editmode:
            mode = subject.mode_name('EDIT' if obj.data.is_editmode else obj.mode)
            raise SceneError(f"'{obj.name}' is in {mode}. It follows when you leave that")

    # What is known

    def _model(self, obj):
        return object_model.of(obj, self.READS)

    def _is_read(self, obj):
        model = self._model(obj)
        if self.READS_AT_REST and self._input is not None and not self._is_quiet(obj):
            return model.is_usable(obj)
        return model.is_read(obj)

    def _is_shown(self, obj):
        """A solve that failed is not to be tried again: there is a problem then."""
        is_written = self.problem is not None or self._model(obj).written is not None
        return self._wanted is not None and self._shown is self._wanted and is_written

    def _quiet_at(self, obj):
        return max(self._changed_at, self._model(obj).rig_moved_at) + QUIET_SECONDS

    def _is_quiet(self, obj):
        return clock() >= self._quiet_at(obj)

    def _show_meanwhile(self, _obj):
        """Whether it shows what is known of an answer that takes longer."""
        return False

    def _has_chores(self, _obj):
        """Whether there is something to be done when all is quiet."""
        return False

    def _do_chores(self, obj):
        """@throws MeanValueError."""

    # Going on

    def _wait_for_job(self, obj, seconds):
        """At most so long, and only if the last solve took no longer."""
        if self._job is not None and self.solve_seconds < seconds and self._job.wait(seconds):
            try:
                self._collect(obj, makes_keys=False)
            except MeanValueError as error:
                self.give_up(str(error))

    def _advance(self, obj, makes_keys=False, is_quiet=False, starts=True):
        """makes_keys: what is found may need a shape key that is not there; is_quiet: do all that is left for a quiet
        moment; starts: begin new jobs."""
        try:
            self._require_ready(obj)
            self._read(obj, is_quiet, is_quiet or (makes_keys and self._job is None and self._is_quiet(obj)))
            if not (makes_keys and self._job is not None):  # of what has moved since it began a handler has heard
                self._look(obj)
            self._collect(obj, makes_keys)
            if self._job is None and self.problem is None and starts:
                self._start_next(obj, makes_keys, is_quiet or (makes_keys and self._is_quiet(obj)))
        except MeanValueError as error:
            self.give_up(str(error))

    def _read(self, obj, is_quiet, compares):
        """compares: keys with what was written, too long for a step of a drag. @throws MeanValueError."""
        model = self._model(obj)
        was_read = model.is_read(obj) if is_quiet else self._is_read(obj)
        if not was_read:
            model.read(obj)
        if compares or not was_read:
            model.compare(obj)
        found = model.result(obj)
        if self._input is None or found.revision != self._input.revision:
            self.stop()
            self._begin_anew()
            self._binding = self._cached_binding(found)
        self._input = found

    def _look(self, obj):
        """Takes what is wanted now. @throws MeanValueError."""
        wanted = self._read_targets(obj)
        if self._wanted is not None and self._is_same_target(wanted, self._wanted):
            return
        if self._job is not None and self._shown is self._wanted is not None:
            self._job.cancel()  # it settles what is not wanted any more
        self.problem = None
        self._wanted, self._is_settled = wanted, False
        self._changed_at = clock()

    def _start_next(self, obj, makes_keys, is_quiet):
        """@throws MeanValueError."""
        if self._binding is None:
            work, collect = self._bind_work(obj)
        elif not self._is_shown(obj) or (is_quiet and not self._is_settled):
            work, collect = self._solve_work(obj, settles=self._is_shown(obj))
        else:
            if is_quiet and makes_keys and self._has_chores(obj):
                self._do_chores(obj)
            return
        self._job = Job(work, of=(self._wanted, collect))

    def _collect(self, obj, makes_keys):
        """@throws MeanValueError."""
        is_finished = self._job is not None and self._job.is_finished
        if not (is_finished and (makes_keys or self._binding is None or self._has_key(obj))):
            return  # tick() collects it: a key that is made in a handler is no part of any undo step
        job, self._job = self._job, None
        wanted, collect = job.of
        try:
            found = job.result()
        except CancelledError:
            return
        except MeanValueError as error:
            self._fail(obj, error, wanted)
        else:
            collect(obj, found)

    def _fail(self, obj, error, wanted):
        """@throws MeanValueError where nothing can be bound."""
        if self._binding is None:
            self._model(obj).refuse(error)  # the same input would fail again
            raise error
        if wanted is self._wanted:
            self._shown, self._is_settled = wanted, True
            self.problem = str(error)

    def _has_key(self, obj):
        return self.READS.written_key(obj) is not None

    def _write(self, obj, shape):
        """Writes n x 3 float32 to the key, made where it is missing."""
        key = self.READS.written_key(obj)
        if key is None:
            with kept.writing(obj):
                self._make_key(obj)
                self._write(obj, shape)
            return
        key_marks.claim(key)
        shape_keys.write_positions(obj.data, key, shape)
        self._model(obj).wrote(shape)
