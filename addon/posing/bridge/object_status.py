# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether an object is bound, stale or not ready, cheap enough for a panel to ask at every redraw: all that takes long
is remembered by its object_model."""

import enum
from dataclasses import dataclass

from ... import wording
from ...errors import SceneError, StaleBindingError
from ...scene import shared_readings
from . import bound_record, scene_input


class State(enum.Enum):
    UNBOUND = "Not bound"
    BOUND = "Bound"
    STALE = "Stale"
    PROBLEM = "Not ready"


@dataclass(frozen=True)
class Status:
    """text: what is wrong, as a sentence; "" if nothing."""

    state: State
    text: str = ""


def status(obj, quiet_seconds=0.0):
    """The Status of a mesh object.

    As it was read last outside Object Mode, for `quiet_seconds` after an edit, and as long as a big mesh is read.
    """
    model = scene_input.model(obj)
    model.is_watched = True
    if obj.mode == 'OBJECT' and not (model.is_usable(obj) and model.was_told_within(quiet_seconds)):
        shared_readings.finished(obj, scene_input.HandleReading)
    bound = obj.meanvalue.bound
    state = State.BOUND if bound.is_bound else State.UNBOUND
    try:
        if model.is_known:
            bound_record.what_changed(bound, model.result(obj).fingerprint)
    except StaleBindingError as problem:
        return Status(State.STALE, wording.sentence(str(problem)))
    except SceneError as problem:
        return Status(State.PROBLEM, wording.sentence(str(problem)))
    return Status(state)


def member_count(obj, name):
    """How many vertices a handle has; None while that is not known."""
    reading = scene_input.model(obj).reading
    members = reading.members if reading is not None else None
    return None if members is None or name not in members else len(members[name])
