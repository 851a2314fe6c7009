# SPDX-License-Identifier: GPL-3.0-or-later
"""What live posing of an object may be doing, and how long it takes for what."""

import enum
import time

from ..errors import MeanValueError

#: How long a handler waits for a solve, so that a quick one is drawn with the move that caused it.
FRAME_SECONDS = 1.0 / 30.0

#: How often a running job is looked at. A look takes 0.03 ms.
TICK_SECONDS = 0.001

#: How long the scene is read at a time.
SLICE_SECONDS = 0.01

#: How long all has to be quiet before the answer is settled, and before doubts are looked into.
QUIET_SECONDS = 0.25

clock = time.monotonic


class State(enum.Enum):
    READING = "the object is read, a slice at a time; a job may still run on what was read before"
    BINDING = "what was read is being bound"
    SOLVING = "the mesh is not where its controls are: a solve runs, or is next"
    SHOWN = "the mesh is where its controls are, by a quick answer; settled when nothing has changed for a moment"
    SETTLING = "the answer that does not depend on the way there is being found"
    SETTLED = "the mesh shows that answer"
    CHECKING = "settled; the object is read again, since what was told as our own writing may have hidden an edit"
    BLOCKED = "the controls cannot be followed where they are: looked at again with every update"
    WAITING = "what was read cannot be posed: nothing is done until the object is edited"


_ANY = frozenset(State)

#: {state: the states that may come next}. Any may be left for READING (an edit, undo), BLOCKED and WAITING (a problem);
#: problems and readings that change nothing go back to where they came from.
TRANSITIONS = {
    State.READING: _ANY - {State.CHECKING},
    State.BINDING: {State.SOLVING},
    State.SOLVING: {State.SHOWN, State.SETTLING, State.SETTLED},
    State.SHOWN: {State.SOLVING, State.SETTLING},
    State.SETTLING: {State.SETTLED, State.SOLVING, State.SHOWN},
    State.SETTLED: {State.SOLVING, State.CHECKING},
    State.CHECKING: {State.SETTLED, State.SOLVING, State.BINDING},
    State.BLOCKED: _ANY - {State.CHECKING},
    State.WAITING: set(),
}


def may_follow(before, after):
    """Whether `after` may come next after `before`."""
    return after in TRANSITIONS[before] or after in {State.READING, State.BLOCKED, State.WAITING}


class NotReadyError(MeanValueError):
    """The object is in the way itself (its mode, a bake): all is read again once it is not."""
