# SPDX-License-Identifier: GPL-3.0-or-later
"""Work that is written as a generator, which yields how far it is and returns its result."""


def result_of(steps, wait=None):
    """Goes through a generator at once. Returns what it returns. wait: called with each step, as to await its end."""
    while True:
        try:
            step = next(steps)
        except StopIteration as end:
            return end.value
        if wait is not None:
            wait(step)


class Pause:
    """Among the native Tasks of a Job: work of Python's own goes on the next time that somebody looks."""

    def __init__(self):
        self._was_seen = False

    @property
    def finished(self):
        was_seen, self._was_seen = self._was_seen, True
        return was_seen

    def wait(self, _seconds=None):
        self._was_seen = True
        return True
