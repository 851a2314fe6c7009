# SPDX-License-Identifier: GPL-3.0-or-later
"""One piece of work on a thread of its own. It gets arrays and gives arrays, and never sees Blender."""

import threading

from .. import native_loader

#: Everything that is running, so that it can be stopped when the add-on is disabled or Blender quits.
_running = set()


class Job:
    """Calls `work(execution)` on a thread; the caller looks at it from time to time.

    work  a function of one argument, the native Execution that it hands to the solver
    """

    def __init__(self, work):
        self._execution = native_loader.module().Execution()
        self._work = work
        self._result = None
        self._error = None
        self._finished = threading.Event()
        _running.add(self)
        # Daemon: Blender quits at once even if a call into the solver takes long to notice that it was cancelled.
        threading.Thread(target=self._run, name="Mean-Value", daemon=True).start()

    def wait(self, seconds=None):
        """Waits at most `seconds` (None: as long as it takes). Returns whether the work is finished."""
        return self._finished.wait(seconds)

    @property
    def is_finished(self):
        return self._finished.is_set()

    @property
    def is_cancelled(self):
        return self._execution.cancelled

    def cancel(self):
        """Asks the work to stop; result() then raises CancelledError, unless it had finished."""
        self._execution.cancel()

    @property
    def progress(self):
        """(name of the stage, share of it that is done)."""
        return self._execution.stage, self._execution.progress

    def result(self):
        """What the work returned; waits for it. @throws whatever it raised."""
        self._finished.wait()
        if self._error is not None:
            raise self._error
        return self._result

    def _run(self):
        try:
            self._result = self._work(self._execution)
        except BaseException as error:  # handed to the main thread, which knows what to do about it
            self._error = error
        finally:
            _running.discard(self)
            self._finished.set()


def cancel_all():
    """Stops everything, and waits for it a little."""
    jobs = list(_running)
    for job in jobs:
        job.cancel()
    for job in jobs:
        job.wait(2.0)
