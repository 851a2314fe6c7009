# SPDX-License-Identifier: GPL-3.0-or-later
"""The binding as it is kept in the .blend, a fingerprint, and whether it is still that of the scene."""

from ... import wording
from ...errors import SceneError, StaleBindingError
from ...scene import declarations
from ...solver import session
from ...solver.core import fingerprint
from . import scene_input


def require_fits(record, now):
    """now: a Fingerprint. @throws StaleBindingError if the artist has to look first: else it is bound again."""
    changes = fingerprint.changes(record, now) if record.is_bound else ""
    if changes:
        raise StaleBindingError(f"{changes}. Check the handles and press Update")


def problem(obj, quiet_seconds=0.0):
    """(why a mesh object cannot be posed by what was read of it, as a sentence; whether Update mends that), or None.

    Cheap enough for drawing: outside Object Mode, and for `quiet_seconds` after an edit, of what was read last.
    """
    model = scene_input.model(obj)
    model.is_watched = True
    if obj.mode == 'OBJECT':
        model.look(obj, quiet_seconds)
    try:
        if model.is_known:
            require_fits(obj.meanvalue.bound, model.result(obj).fingerprint)
    except SceneError as error:
        return wording.sentence(str(error)), isinstance(error, StaleBindingError)
    return None


def write(record, now):
    """Remembers the binding of a Fingerprint: what of it the artist has to look at where it is another."""
    record.vertex_count, record.faces, record.rest_shape = now.vertex_count, now.faces, now.rest_shape
    record.is_bound = record.knows_seams = True


def release(record):
    """Forgets the binding that there is, and frees its memory, with that of others which nothing holds now."""
    session.cache.clear()
    declarations.clear(record)
