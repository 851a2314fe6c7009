# SPDX-License-Identifier: GPL-3.0-or-later
"""Stand-ins for the native module's tasks."""

import time


class Until:
    """Finished as soon as `condition()` holds."""

    def __init__(self, condition):
        self._condition = condition

    @property
    def finished(self):
        return self._condition()

    def wait(self, seconds=None):
        until = time.monotonic() + (60.0 if seconds is None else seconds)
        while not self.finished and time.monotonic() < until:
            time.sleep(0.001)
        return self.finished


class Changed:
    """A task whose result goes through `change` first."""

    def __init__(self, task, change):
        self._task = task
        self._change = change

    @property
    def finished(self):
        return self._task.finished

    def wait(self, seconds=None):
        return self._task.wait(seconds)

    def result(self):
        return self._change(self._task.result())
