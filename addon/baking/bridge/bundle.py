# SPDX-License-Identifier: GPL-3.0-or-later
"""A BakePlan as a file (npz), so that a farm solves what was planned, whatever becomes of the scene."""

import hashlib
import pathlib
from dataclasses import fields

import numpy as np

from ...errors import CacheError
from ...posing.core.bind_input import BindInput
from ...scene.core import whole_files
from .plan import BakePlan

_OF_PLAN = ("times", "spacing", "targets", "weights", "portable")


def save(path, plan, triangles):
    """triangles m x 3 int32. Returns the file's SHA-256, which load() wants. @throws CacheError."""
    values = {f"mesh_{field.name}": getattr(plan.bind_input, field.name) for field in fields(BindInput)}
    values.update({name: getattr(plan, name) for name in _OF_PLAN})
    with whole_files.replacing(path) as file:
        np.savez(file, triangles=triangles, **{name: value for name, value in values.items() if value is not None})
        file.seek(0)
        return _digest(file)


def load(path, sha256):
    """(BakePlan, triangles). Nothing is made of a file that is not what was written. @throws CacheError."""
    with whole_files.telling(path), pathlib.Path(path).open("rb") as file:
        if _digest(file) != sha256:
            raise CacheError(f"'{path}' is not what was planned: it is damaged, or of another plan. Plan again")
        file.seek(0)
        with np.load(file, allow_pickle=False) as values:
            mesh = {field.name: _value(values, f"mesh_{field.name}") for field in fields(BindInput)}
            plan = BakePlan(BindInput(**mesh), **{name: _value(values, name) for name in _OF_PLAN})
            return plan, values["triangles"]


def _digest(file):
    state = hashlib.sha256()
    while piece := file.read(1 << 20):
        state.update(piece)
    return state.hexdigest()


def _value(values, name):
    """An array, or what was one number or text, or None where there was nothing."""
    if name not in values:
        return None
    value = values[name]
    return value.item() if value.ndim == 0 else value
