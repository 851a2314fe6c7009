# SPDX-License-Identifier: GPL-3.0-or-later
"""What a follower tells of itself."""

import traceback

from .. import wording
from .states import State


class Telling:
    """Mix-in of Following."""

    #: States in which the mesh shows where the controls are.
    CAUGHT_UP = frozenset({State.SHOWN, State.SETTLING, State.SETTLED, State.CHECKING})

    @property
    def name_shown(self):
        """What it is called in the panel, and here."""
        return "Live"

    @property
    def reading_text(self):
        return "Live: reading the mesh"

    @property
    def is_caught_up(self):
        """Whether the mesh shows where the controls are, or something is in the way."""
        return self.problem is not None or self.state in self.CAUGHT_UP

    @property
    def is_resting(self):
        """Whether the mesh shows the settled answer, as far as is known."""
        return self.state in {State.SETTLED, State.CHECKING}

    @property
    def has_more_to_do(self):
        """Whether tick() is to be called soon."""
        return self.is_working or (self.problem is None and not self.is_resting)

    @property
    def is_working(self):
        return self._job is not None or self.state in {State.READING, State.CHECKING}

    @property
    def is_reading(self):
        """Whether it has to read the mesh before anything else."""
        return self.state is State.READING

    @property
    def text(self):
        """For the panel."""
        name = self.name_shown
        if self.problem:
            return wording.sentence(f"{name} is waiting: {self.problem}")
        if self.state is State.READING:
            return self.reading_text
        if self.state is State.BINDING:
            stage, share = self._job.progress if self._job is not None else ("", 0.0)
            stage, share = wording.stage(stage), f"{share:.0%}"
            return f"{name}: binding, {stage}, {share}"
        if self.state is State.SOLVING:
            return f"{name}: solving"
        speed = name
        if self.solve_seconds:
            seconds = wording.seconds(self.solve_seconds)
            speed = f"{name}: {seconds} a solve"
        return " ".join(wording.sentence(each) for each in (speed, *self._notes()))

    def _notes(self):
        """What the artist may not expect of what is shown, in sentences."""
        return ()


class reporting:
    """Context manager: an error that nobody foresaw ends the work on one object alone, and is told."""

    def __init__(self, follower):
        self._follower = follower

    def __enter__(self):
        return self

    def __exit__(self, _kind, error, _trace):
        if not isinstance(error, Exception):
            return False
        traceback.print_exception(error)
        self._follower.give_up(
            f"the add-on failed ({type(error).__name__}: {error}). Please report this with the text in the system "
            "console; turn Live off and on to go on"
        )
        return True
