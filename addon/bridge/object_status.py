# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether an object is bound, stale or not ready, remembered so that a panel can ask at every redraw.

Reading a mesh of 50,000 vertices takes 40 ms, so it is read again only after Blender said that the object's geometry
was updated, or when something that is cheap to compare (names, counts, settings) differs. Geometry is updated at
every step of a drag or of playback: a panel waits until the object has been left alone for a moment.
"""

import enum
import time
from dataclasses import dataclass, field

from .. import compat
from ..core import fingerprint, wording
from ..core.edit_times import QUIET_SECONDS, EditTimes  # noqa: F401  panels take the seconds from here
from ..errors import SceneError
from . import bound_record, mirrors, scene_input, shared_readings


class State(enum.Enum):
    UNBOUND = "Not bound"
    BOUND = "Bound"
    STALE = "Stale"
    PROBLEM = "Not ready"


@dataclass(frozen=True)
class Status:
    """What the panel shows. `member_counts`: vertices of each listed group that exists; of none while unknown."""

    state: State
    text: str
    member_counts: dict = field(default_factory=dict)


clock = time.monotonic

_known = {}  # session key: (signature, Status)
_edited = EditTimes(lambda: clock())  # by session key


def mark_edited(obj):
    """Returns whether somebody has asked for the object's status, and so may have to ask again."""
    key = compat.session_key(obj)
    if key in _known:
        _edited.mark(key)
    return key in _known


quiet_in = _edited.quiet_in


def clear():
    _known.clear()
    _edited.clear()


def status(obj, quiet_seconds=0.0):
    """The Status of a mesh object.

    The last known one outside Object Mode, for `quiet_seconds` after an edit, and as long as a big mesh is read.
    """
    key = compat.session_key(obj)
    signature = _signature(obj)
    known_signature, known = _known.get(key, (None, None))
    if known_signature == signature and not _edited.is_left_alone(key, quiet_seconds):
        return known
    reading = shared_readings.finished(obj) if obj.mode == 'OBJECT' else None
    if reading is None:
        is_good = known_signature == signature or (known is not None and obj.mode == 'OBJECT')
        return known if is_good else _unread(obj)
    known = _read(obj, reading)
    _known[key] = (signature, known)
    _edited.pop(key, None)
    return known


def last_known(obj):
    """The Status as it was last read, or None. Takes no time."""
    return _known.get(compat.session_key(obj), (None, None))[1]


def _signature(obj):
    """All that is quick to compare, and what Blender does not report as an update (removing a group by a script)."""
    settings = obj.meanvalue
    record = settings.bound
    return (
        obj.name,
        obj.data.name,
        len(obj.data.vertices),
        len(obj.data.polygons),
        tuple(obj.vertex_groups.keys()),
        tuple(group.name for group in settings.anchor_groups),
        settings.roi_group,
        settings.roi_invert,
        settings.method,
        settings.rigidity,
        mirrors.signature(obj),
        tuple((group.is_enabled, group.follows, group.is_soft, group.strength) for group in settings.anchor_groups),
        bound_record.read_fingerprint(record),
        record.seconds,
    )


def _unread(obj):
    is_waiting = obj.mode == 'OBJECT'
    why = "the mesh is being read" if is_waiting else f"not checked in {scene_input.mode_name(obj.mode)}"
    if obj.meanvalue.bound.is_bound:
        return Status(State.BOUND, f"{_bound_text(obj)} ({why})")
    return Status(State.UNBOUND, f"Not bound ({why})")


def _read(obj, reading):
    names = {group.name for group in obj.meanvalue.anchor_groups}
    counts = {name: len(indices) for name, indices in reading.members.items() if name in names}
    state, text = _state_and_text(obj, reading)
    return Status(state, text, counts)


def _state_and_text(obj, reading):
    bound = bound_record.read_fingerprint(obj.meanvalue.bound)
    try:
        now = scene_input.gather(obj, reading).fingerprint
    except SceneError as problem:
        return State.PROBLEM, wording.sentence(str(problem))
    if bound is None:
        return State.UNBOUND, "Not bound. Press Bind."
    reasons = fingerprint.stale_reasons(bound, now)
    if not reasons:
        return State.BOUND, _bound_text(obj)
    changes = fingerprint.describe(reasons, bound, now)
    if fingerprint.needs_bind(reasons):
        return State.STALE, f"Stale: {changes}. Check the anchors and press Bind."
    return State.STALE, f"Stale: {changes}. Solve will bind again."


def _bound_text(obj):
    return f"Bound: {bound_record.read_summary(obj.meanvalue.bound).text()}"
