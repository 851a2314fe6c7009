# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether an object is bound, stale or not ready, cheap enough for a panel to ask at every redraw: all that takes long
is remembered by its object_model."""

import enum
from dataclasses import dataclass

from ... import wording
from ...errors import SceneError
from ...scene import shared_readings
from ...solver.core import fingerprint
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
    bound = bound_record.read_fingerprint(obj.meanvalue.bound)
    if not model.is_known:
        return Status(State.UNBOUND if bound is None else State.BOUND)
    try:
        now = model.result(obj).fingerprint
    except SceneError as problem:
        return Status(State.PROBLEM, wording.sentence(str(problem)))
    if bound is None:
        return Status(State.UNBOUND)
    reasons = fingerprint.stale_reasons(bound, now)
    if not fingerprint.needs_bind(reasons):
        return Status(State.BOUND)
    changes = fingerprint.describe(reasons, bound, now)
    return Status(State.STALE, wording.sentence(f"{changes}. Check the handles and press Update"))


def member_count(obj, name):
    """How many vertices a handle has; None while that is not known."""
    reading = scene_input.model(obj).reading
    members = reading.members if reading is not None else None
    return None if members is None or name not in members else len(members[name])
