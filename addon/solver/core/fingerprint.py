# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a mesh is still the one that was bound, told from its content alone.

A binding is remembered as a fingerprint of everything it depends on. It is kept in the .blend, so it follows undo,
duplication, renaming and reopening without any bookkeeping.
"""

import enum
import functools
import hashlib
from dataclasses import astuple, dataclass

import numpy as np

from ... import wording


class StaleReason(enum.Enum):
    """Everything that can make a binding stale; the value says it in the middle of a sentence."""

    VERTICES = "vertices changed"
    FACES = "faces changed"
    REST_SHAPE = "rest shape changed"
    ANCHORS = "handles changed"
    ROI = "region changed"
    SETTINGS = "settings changed"
    MIRROR = "mirror planes changed"


#: After these the anchors may no longer mean the same vertices: the artist must look and bind again.
NEEDS_BIND = frozenset({StaleReason.VERTICES, StaleReason.FACES, StaleReason.REST_SHAPE})


#: Results of a `remembered` function that are kept.
REMEMBERED = 4


@dataclass(frozen=True)
class Fingerprint:
    """Counts (for messages) and digests (for comparing) of what a binding depends on."""

    vertex_count: int
    face_count: int
    faces: str
    rest_shape: str
    anchors: str
    roi: str
    settings: str
    mirror: str = ""

    @property
    def key(self):
        """One hashable value for the whole content."""
        return astuple(self)

    @property
    def shape_key(self):
        """The same of the mesh, what mirrors it and its region alone, whatever is anchored in it."""
        return (self.vertex_count, self.face_count, self.faces, self.rest_shape, self.roi, self.mirror)


def digest(*parts):
    """Hex digest of numpy arrays and texts, their types and shapes included. About 1 ms per megabyte."""
    state = hashlib.blake2b(digest_size=16)
    for part in parts:
        if isinstance(part, str):
            state.update(part.encode())
            continue
        array = np.ascontiguousarray(part)
        state.update(f"{array.dtype.str}{array.shape}".encode())
        state.update(array.tobytes())
    return state.hexdigest()


def remembered(function):
    """Decorator of a function of arrays and numbers to an array: the last few results are kept by the arguments'
    content, since a mesh is read again after every edit of anything. They are not to be written to."""
    known = {}

    @functools.wraps(function)
    def result_of(*arguments):
        key = digest(*arguments)
        if key not in known:
            result = function(*arguments)
            result.flags.writeable = False
            while len(known) >= REMEMBERED:
                del known[next(iter(known))]
            known[key] = result
        return known[key]

    return result_of


def stale_reasons(bound, now):
    """The reasons in the order of StaleReason; empty when the binding is good.

    With another vertex count every other digest differs too, which would say nothing new: it is left out.
    """
    if bound.vertex_count != now.vertex_count:
        changed_faces = bound.face_count != now.face_count
        return (StaleReason.VERTICES, StaleReason.FACES) if changed_faces else (StaleReason.VERTICES,)
    pairs = (
        (StaleReason.FACES, bound.faces, now.faces),
        (StaleReason.REST_SHAPE, bound.rest_shape, now.rest_shape),
        (StaleReason.ANCHORS, bound.anchors, now.anchors),
        (StaleReason.ROI, bound.roi, now.roi),
        (StaleReason.SETTINGS, bound.settings, now.settings),
        (StaleReason.MIRROR, bound.mirror, now.mirror),
    )
    return tuple(reason for reason, before, after in pairs if before != after)


def needs_bind(reasons):
    """True if the artist must press Update; else what poses the mesh next binds again by itself."""
    return not NEEDS_BIND.isdisjoint(reasons)


def describe(reasons, bound, now):
    """What changed, as part of a sentence, with both counts: "the mesh has 26 vertices (25 when bound)"."""
    counts = []
    if StaleReason.VERTICES in reasons:
        counts.append(f"{wording.vertices(now.vertex_count)} ({bound.vertex_count:,} when bound)")
    if StaleReason.FACES in reasons and bound.face_count != now.face_count:
        counts.append(f"{wording.counted(now.face_count, 'face')} ({bound.face_count:,} when bound)")
    parts = [f"the mesh has {wording.listed(counts)}"] if counts else []
    if StaleReason.FACES in reasons and bound.face_count == now.face_count:
        parts.append(f"the {wording.counted(now.face_count, 'face')} join the vertices in another way")
    if StaleReason.REST_SHAPE in reasons:
        parts.append("the rest shape was edited")
    others = (StaleReason.ANCHORS, StaleReason.ROI, StaleReason.SETTINGS, StaleReason.MIRROR)
    parts.extend(f"the {reason.value}" for reason in others if reason in reasons)
    return wording.listed(parts)
