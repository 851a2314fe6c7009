# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether an object is bound, stale or not ready, remembered so that a panel can ask at every redraw.

Reading a mesh of 50,000 vertices takes 40 ms, so it is read again only when its object_model says that it may be
another. Geometry is updated at every step of a drag or of playback: a panel waits until the object has been left alone
for a moment.
"""

import enum
from dataclasses import dataclass, field

from ... import compat, wording
from ...errors import SceneError
from ...scene import shared_readings, subject
from ...scene.object_model import QUIET_SECONDS  # noqa: F401  panels take the seconds from here
from ...solver.core import fingerprint
from . import bound_record, scene_input


class State(enum.Enum):
    UNBOUND = "Not bound"
    BOUND = "Bound"
    STALE = "Stale"
    PROBLEM = "Not ready"


@dataclass(frozen=True)
class Status:
    """What the panel shows. `member_counts`: vertices of each handle that exists; of none while unknown."""

    state: State
    text: str
    member_counts: dict = field(default_factory=dict)


#: What is to be done next where all is ready and nothing is bound: Live and Bake do that by themselves.
NOT_SEEN_YET = "To see the mesh follow, press Live, or Bake"

_known = {}  # session key: (stamp of its model, what it was bound as, Status)


def clear():
    _known.clear()


def status(obj, quiet_seconds=0.0):
    """The Status of a mesh object.

    The last known one outside Object Mode, for `quiet_seconds` after an edit, and as long as a big mesh is read.
    """
    key = compat.session_key(obj)
    model = scene_input.model(obj)
    model.is_watched = True
    bound = _bound_as(obj)
    stamp, known_bound, known = _known.get(key, (None, None, None))
    is_same_binding = known is not None and known_bound == bound
    if is_same_binding and model.is_current(obj, stamp, quiet_seconds):
        return known
    reading = shared_readings.finished(obj, scene_input.HandleReading) if obj.mode == 'OBJECT' else None
    if reading is None:
        is_good = is_same_binding and stamp.signature == model.stamp(obj).signature
        return known if is_good or (known is not None and obj.mode == 'OBJECT') else _unread(obj)
    known = _read(obj, reading)
    _known[key] = (model.stamp(obj), bound, known)
    return known


def last_known(obj):
    """The Status as it was last read, or None. Takes no time."""
    return _known.get(compat.session_key(obj), (None, None, None))[2]


def _bound_as(obj):
    return bound_record.read_fingerprint(obj.meanvalue.bound), obj.meanvalue.bound.seconds


def _unread(obj):
    is_waiting = obj.mode == 'OBJECT'
    mode = subject.mode_name(obj.mode)
    why = "the mesh is being read" if is_waiting else f"not checked in {mode}"
    if obj.meanvalue.bound.is_bound:
        return Status(State.BOUND, f"{_bound_text(obj)} ({why})")
    return Status(State.UNBOUND, f"Not bound ({why})")


def _read(obj, reading):
    names = {handle.name for handle in obj.meanvalue.handles}
    counts = {name: len(indices) for name, indices in reading.members.items() if name in names}
    state, text = _state_and_text(obj)
    return Status(state, text, counts)


def _state_and_text(obj):
    bound = bound_record.read_fingerprint(obj.meanvalue.bound)
    try:
        now = scene_input.model(obj).result(obj).fingerprint
    except SceneError as problem:
        return State.PROBLEM, wording.sentence(str(problem))
    if bound is None:
        return State.UNBOUND, f"{NOT_SEEN_YET}."
    reasons = fingerprint.stale_reasons(bound, now)
    if not reasons:
        return State.BOUND, _bound_text(obj)
    changes = fingerprint.describe(reasons, bound, now)
    if fingerprint.needs_bind(reasons):
        return State.STALE, wording.sentence(f"{changes}. Check the handles and press Update")
    return State.BOUND, wording.sentence(f"{changes}, which the next pose takes in")


def _bound_text(obj):
    return f"Bound: {bound_record.read_summary(obj.meanvalue.bound).text()}"
