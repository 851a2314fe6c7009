# SPDX-License-Identifier: GPL-3.0-or-later
"""A BakePlan as a file (npz), so that a farm solves what was planned, whatever becomes of the scene."""

import zipfile
from dataclasses import fields

import numpy as np

from ..core import whole_files
from ..core.bind_input import BindInput
from ..errors import CacheError
from .plan import BakePlan

_OF_PLAN = ("times", "spacing", "targets", "weights", "portable")


def save(path, plan, triangles):
    """triangles m x 3 int32. @throws CacheError."""
    values = {f"mesh_{field.name}": getattr(plan.bind_input, field.name) for field in fields(BindInput)}
    values.update({name: getattr(plan, name) for name in _OF_PLAN})
    with whole_files.replacing(path) as file:
        np.savez(file, triangles=triangles, **{name: value for name, value in values.items() if value is not None})


def load(path):
    """(BakePlan, triangles). @throws CacheError."""
    try:
        with whole_files.telling(path), np.load(path, allow_pickle=False) as values:
            mesh = {field.name: _value(values, f"mesh_{field.name}") for field in fields(BindInput)}
            plan = BakePlan(BindInput(**mesh), **{name: _value(values, name) for name in _OF_PLAN})
            return plan, values["triangles"]
    except (ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise CacheError(f"'{path}' is damaged ({error}). Plan again") from error


def _value(values, name):
    """An array, or what was one number or text, or None where there was nothing."""
    if name not in values:
        return None
    value = values[name]
    return value.item() if value.ndim == 0 else value
