# SPDX-License-Identifier: GPL-3.0-or-later
"""What following handles and following sliders have in common: states, jobs, problems.

One job at a time runs beside the interface. What comes in meanwhile replaces what is wanted and never queues up. When
nothing has changed for a moment the answer is settled, so that it does not depend on the way there.

live/states.py names the states. `_advance()` goes from one to the next: it reads what has to be read, takes what is
wanted now, collects the job that is finished and starts the next one.
"""

import contextlib

import numpy as np

from ..errors import CancelledError, MeanValueError
from ..scene import object_model
from ..solver.job import Job
from . import states
from .states import NotReadyError, State
from .telling import Telling


class Following(Telling):
    """Use on the main thread only. Knows of the object only its name; the object is handed in with each call.

    problem        says in words why the mesh does not follow, or is None
    solve_seconds  of the last solve
    hears_itself   whether Blender tells of what tick() writes, as its interface does. What is written in its own
                   handlers, by follow(), it evaluates without telling.

    Subclasses define why_hidden() and what is called here and begins with an underscore and is not defined here.
    """

    #: Whether what is wanted is so quick to read that it is read with every tick.
    LOOKS_ALWAYS = False

    def __init__(self, obj, hears_itself):
        self.name = obj.name
        self.problem = None
        self.solve_seconds = 0.0
        self.state = State.READING
        self._hears_itself = hears_itself
        self._is_finishing = False
        self._noticed = None  # stamp of the object's model when it was looked at last
        self._job = None
        self.look_again()

    def look_again(self):
        """The scene may be another one by now (undo, edit): take nothing for granted but what is read again."""
        self.stop()
        self.problem = None
        self._seen = None  # stamp of the object's model that _input is of
        self._input = None
        self._nothing_known()
        self.state = State.READING

    def _nothing_known(self):
        self._binding = None
        self._wanted = None  # where the controls are
        self._shown = None  # where they were for the answer that the mesh shows
        self._settled = None  # and where, if that is settled
        self._failed = self._failure = None  # what could not be reached, and why in words
        self._changed_at = states.clock()

    def stop(self):
        """Cancels what is running; its result is dropped."""
        if self._job is not None:
            self._job.drop()
        self._job = self._collect = None

    def give_way(self, other_name):
        """Another object with the same mesh is live."""
        self._give_up(self._why_it_gives_way(other_name), State.BLOCKED)

    def give_up(self, problem):
        """Until the object is edited."""
        self._give_up(problem, State.WAITING)

    def _give_up(self, problem, state):
        self.look_again()
        self.problem = problem
        self.state = state

    def follow(self, obj):
        """Takes the controls where they are now, and waits at most a frame for the mesh to follow."""
        patience = states.FRAME_SECONDS if self.solve_seconds < states.FRAME_SECONDS else 0.0
        with self._in_a_handler():
            self._advance(obj, looks=True, patience=patience)

    def tick(self, obj, looks=False):
        """Collects what is finished and starts what is next. Returns seconds until the next call, None for never.

        looks: take the controls where they are now, which else follow() does.
        """
        if looks or self._job is None or self._job.is_finished or self.state is State.READING:
            self._advance(obj, looks)
        if self.state in {State.READING, State.CHECKING}:
            return states.TICK_SECONDS
        if self._job is not None:
            return states.TICK_SECONDS if self.problem is None else states.QUIET_SECONDS
        if self.state is State.SHOWN or (self.state is State.SETTLED and self._has_doubts(obj)):
            return max(states.TICK_SECONDS, self._changed_at + states.QUIET_SECONDS - states.clock())
        return None

    def finish(self, obj):
        """Goes on until the mesh shows the settled answer. For the background, where nothing ticks."""
        self._is_finishing = True
        try:
            self._advance(obj, looks=True)
            while self.problem is None and (self.state is not State.SETTLED or self._has_doubts(obj)):
                if self._job is not None:
                    self._job.wait()
                self._advance(obj)
        finally:
            self._is_finishing = False

    def is_settled(self, obj):
        """Whether the mesh shows the settled answer to where the controls are now; so too where it cannot follow."""
        self._is_finishing = True
        try:
            self._advance(obj, looks=True, starts=False)
        finally:
            self._is_finishing = False
        return self.problem is not None or self.is_resting

    # From state to state

    def _advance(self, obj, looks=False, patience=0.0, starts=True):
        """looks: take the controls where they are; patience: wait so long for a job; starts: begin new jobs."""
        with self._telling_problems():
            if not self._notice(obj):
                return
            self._require_ready(obj)
            if self.state is State.READING:
                if not self._read(obj):
                    return
                looks = True
            if looks or self.LOOKS_ALWAYS:
                self._look(obj)
            self._collect_finished(obj)
            has_time = not (looks and self.is_resting) or self._is_finishing  # doubts wait for tick()
            if self._job is None and starts and has_time:
                self._start_next(obj)
                if self._job is not None and patience and self._job.wait(patience):
                    self._collect_finished(obj)

    def _notice(self, obj):
        """Enters READING where the object may be another. Returns whether there is anything to do."""
        model = object_model.of(obj)
        before, self._noticed = self._noticed, model.stamp
        if self.state is State.WAITING:
            if before == model.stamp:
                return False
            self.look_again()
        elif self.state is not State.READING and self._must_read(obj, model):
            self.state = State.READING
        return True

    def _read(self, obj):
        """Reads for a moment. Returns whether all is read, and then leaves READING. @throws MeanValueError."""
        seconds = np.inf if self._is_finishing else states.SLICE_SECONDS
        self.problem = None
        if not self._read_on(obj, seconds):
            return False
        found = self._gather(obj)
        self._seen = object_model.of(obj).stamp
        self._take(obj, found)
        self._resume()
        return True

    def _take(self, obj, found):
        former, self._input = self._input, found
        if former is None or not self._is_same_input(former, found):
            self.stop()
            self._nothing_known()
            self._binding = self._cached_binding()
        else:
            self._require_shown(obj)

    def _look(self, obj):
        """Takes what is wanted now. @throws MeanValueError."""
        wanted = self._read_targets(obj)
        if self._wanted is not None and self._is_same_target(wanted, self._wanted):
            if self.state is State.BLOCKED:
                self._resume()
            return
        self.problem = None
        self._wanted = wanted
        self._changed_at = states.clock()
        if self.state is State.SETTLING:
            self._job.cancel()
        self.state = State.BINDING if self._binding is None else State.SOLVING

    def _resume(self):
        self.state = self._where_it_is()
        self.problem = self._failure if self.state is State.BLOCKED else None

    def _where_it_is(self):
        """The state that follows from what is known."""
        if self._wanted is not None and self._failed is self._wanted:
            return State.BLOCKED
        if self._binding is None:
            return State.BINDING
        if self._wanted is None or self._shown is not self._wanted:
            return State.SOLVING
        if self._job is not None:
            return State.SETTLING
        return State.SETTLED if self._settled is self._wanted else State.SHOWN

    def _start_next(self, obj):
        if self.state is State.BINDING:
            self._start(self._bind_work(obj), self._keep_binding)
        elif self.state is State.SOLVING and self._wanted is not None:
            self._start(*self._solving(obj))
        elif self.state is State.SHOWN and self._is_quiet():
            self._start(*self._settling(obj))
            self.state = State.SETTLING
        elif self.state is State.SETTLED and self._has_doubts(obj) and self._is_quiet():
            self._start_check(obj)
            self.state = State.CHECKING
        elif self.state is State.CHECKING and self._check_on(
            obj, np.inf if self._is_finishing else states.SLICE_SECONDS
        ):
            self._resume()  # what it shows may have been found to be somebody else's
            self._look(obj)
            if not self.is_resting:
                self._start_next(obj)

    def _start(self, work, collect):
        self._job = Job(work)
        self._collect = collect

    def _collect_finished(self, obj):
        if self._job is None or not self._job.is_finished:
            return
        job, collect = self._job, self._collect
        self._job = self._collect = None
        try:
            outcome = job.result()
        except CancelledError:
            pass
        except MeanValueError as error:
            if self._binding is None:
                self.give_up(str(error))  # the same input would fail again
                return
            self._failed, self._failure = self._wanted, str(error)  # not again for the same targets
            raise
        else:
            collect(obj, outcome)
        if self.state is not State.BLOCKED:
            self.state = self._where_it_is()

    def _is_quiet(self):
        return self._is_finishing or states.clock() >= self._changed_at + states.QUIET_SECONDS

    def _expect_echo(self, obj):
        if self._hears_itself:
            object_model.of(obj).wrote()

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
        except NotReadyError as error:
            self._give_up(str(error), State.BLOCKED)
        except MeanValueError as error:
            if self.state in {State.READING, State.CHECKING}:
                self.give_up(str(error))
            else:
                self.problem = str(error)
                self.state = State.BLOCKED
