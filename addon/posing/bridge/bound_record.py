# SPDX-License-Identifier: GPL-3.0-or-later
"""The binding as it is kept in the .blend: a fingerprint and the figures that the panel shows."""

from dataclasses import fields

from ...solver.core.fingerprint import Fingerprint
from ...solver.core.result import BindSummary, SolveSummary


def read_fingerprint(record):
    """The Fingerprint that was bound, or None if nothing is."""
    return _read(record, Fingerprint) if record.is_bound else None


def read_summary(record):
    return _read(record, BindSummary)


def write(record, fingerprint, summary):
    """Remembers a binding. What an earlier solve found no longer belongs to it."""
    _write(record, fingerprint)
    _write(record, summary)
    record.is_bound = True
    record.is_solved = False


def write_solve(record, summary):
    _write(record, summary)
    record.is_solved = True


def read_solve(record):
    """The SolveSummary of the last solve, or None."""
    return _read(record, SolveSummary) if record.is_solved else None


def clear(record):
    for prop in record.bl_rna.properties:
        if prop.identifier not in {"rna_type", "name"}:
            record.property_unset(prop.identifier)


def _read(record, kind):
    return kind(**{field.name: getattr(record, _property_name(kind, field)) for field in fields(kind)})


def _write(record, value):
    for field in fields(value):
        setattr(record, _property_name(type(value), field), getattr(value, field.name))


def _property_name(kind, field):
    """Fields of the solve summary are prefixed, since both summaries have seconds."""
    return f"solve_{field.name}" if kind is SolveSummary else field.name
