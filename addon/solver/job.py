# SPDX-License-Identifier: GPL-3.0-or-later
"""Work beside the interface: steps on the main thread, and between them the solver on threads of its own.

No thread of Python's runs beside Blender: up to Python 3.11, Blender takes "some thread runs Python" for "this one
may", and crashes when it runs an operator or a driver in that moment (decision 0009).
"""

import math
import time

from . import native_loader

#: Everything that is running, so that it can be stopped when the add-on is disabled or Blender quits.
_running = set()


class Job:
    """Runs `work(execution)`, a generator of native Tasks: each Task has to finish before the generator goes on.

    It goes on only while the caller looks at the job, by `is_finished`, wait() or result(). `of` is the caller's own
    note of what the job is for.
    """

    def __init__(self, work, of=None):
        self.of = of
        self._execution = native_loader.module().Execution()
        self._steps = work(self._execution)
        self._task = self._result = self._error = None
        _running.add(self)
        self._go_on()

    def wait(self, seconds=None):
        """Waits at most `seconds` (None: as long as it takes). Returns whether the work is finished."""
        until = time.monotonic() + (math.inf if seconds is None else seconds)
        while not self.is_finished:
            left = until - time.monotonic()
            if left <= 0.0:
                return False
            self._task.wait(None if seconds is None else left)
        return True

    @property
    def is_finished(self):
        """Whether the work is over. Goes on with it if a Task is finished."""
        while self._task is not None and self._task.finished:
            self._go_on()
        return self._task is None

    @property
    def is_cancelled(self):
        return self._execution.cancelled

    def cancel(self):
        """Asks the work to stop; result() then raises CancelledError, unless it had finished."""
        self._execution.cancel()

    def drop(self):
        """Cancels it and forgets it: nobody will look at it any more. What the solver still holds it frees itself."""
        self.cancel()
        self._end()

    @property
    def early(self):
        """What the native Task at work has to offer before its result, or None."""
        return getattr(self._task, "early", None)

    @property
    def progress(self):
        """(name of the stage, share of it that is done)."""
        return self._execution.stage, self._execution.progress

    def result(self):
        """What the work returned; waits for it. @throws whatever it raised."""
        self.wait()
        if self._error is not None:
            raise self._error
        return self._result

    def _go_on(self):
        self._task = None
        try:
            self._task = next(self._steps)
        except StopIteration as end:
            self._result = end.value
        except BaseException as error:  # for whoever asks for the result
            self._error = error
        if self._task is None:
            self._end()

    def _end(self):
        """Lets go of the arrays that the steps hold."""
        self._task = None
        self._steps.close()
        _running.discard(self)


def result_of(steps, wait=None):
    """Goes through a generator at once. Returns what it returns. wait: called with each step, as to await its end."""
    while True:
        try:
            step = next(steps)
        except StopIteration as end:
            return end.value
        if wait is not None:
            wait(step)


def cancel_all():
    """Stops everything, and waits for it a little."""
    jobs = list(_running)
    for job in jobs:
        job.cancel()
    for job in jobs:
        job.wait(2.0)
