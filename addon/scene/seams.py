# SPDX-License-Identifier: GPL-3.0-or-later
"""Which vertices of an object move as one: the one reading of its seams, for all rooms."""

from . import kept, shape_keys
from .core import welding


def signature(obj):
    """The settings that say so, to be compared."""
    return obj.meanvalue.close_seams, obj.meanvalue.merge_distance


def copies(obj, rest=None):
    """As of welding.copies(), in the rest shape, which may be at hand; None where each vertex is its own."""
    rest, given = shape_keys.rest_positions(obj.data) if rest is None else rest, signature(obj)
    return kept.of(obj.data, "copies", lambda: welding.copies(rest, *given, *kept.faces(obj.data)), rest, *given)
