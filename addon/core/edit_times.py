# SPDX-License-Identifier: GPL-3.0-or-later
"""What was edited and not read since: it is read again when it has been left alone for a moment."""

#: How long a thing has to be left alone before it is read again.
QUIET_SECONDS = 0.3


class EditTimes(dict):
    """{key: when it was last edited} by `clock`, which tells seconds. What is read again is removed by the reader."""

    def __init__(self, clock):
        super().__init__()
        self._clock = clock

    def mark(self, key):
        self[key] = self._clock()

    def is_left_alone(self, key, quiet_seconds=QUIET_SECONDS):
        """Whether `key` was edited, and not for `quiet_seconds` since."""
        return key in self and self._clock() - self[key] >= quiet_seconds

    def quiet_in(self):
        """Seconds until everything has been left alone long enough; 0 if it has."""
        return max([0.0, *(when + QUIET_SECONDS - self._clock() for when in self.values())])
