# SPDX-License-Identifier: GPL-3.0-or-later
"""The binding as it is kept in the .blend: a fingerprint and the figures that the panel shows."""

from dataclasses import fields

from ...errors import StaleBindingError
from ...solver.core import fingerprint
from ...solver.core.fingerprint import Fingerprint


def read_fingerprint(record):
    """The Fingerprint that was bound, or None if nothing is."""
    if not record.is_bound:
        return None
    return Fingerprint(**{field.name: getattr(record, field.name) for field in fields(Fingerprint)})


def what_changed(record, now):
    """What is another one than what is bound, in words, where that need not stop us; "" if nothing, None if nothing is
    bound. now: a Fingerprint. @throws StaleBindingError if the artist has to look first."""
    bound = read_fingerprint(record)
    if bound is None:
        return None
    changes, needs_update = fingerprint.changes(bound, now)
    if needs_update:
        raise StaleBindingError(f"{changes}. Check the handles and press Update")
    return changes


def write(record, now, summary):
    """Remembers a binding. What an earlier solve found no longer belongs to it."""
    _write(record, now)
    _write(record, summary)
    record.is_bound = True
    record.is_solved = False


def write_solve(record, summary):
    _write(record, summary, "solve_")
    record.is_solved = True


def clear(record):
    for prop in record.bl_rna.properties:
        if prop.identifier not in {"rna_type", "name"}:
            record.property_unset(prop.identifier)


def _write(record, value, prefix=""):
    for field in fields(value):
        setattr(record, prefix + field.name, getattr(value, field.name))
