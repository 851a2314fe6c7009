# SPDX-License-Identifier: GPL-3.0-or-later
"""Which vertices of an object move as one: the one reading of its seams, for all rooms."""

from . import kept, shape_keys
from .core import welding


def signature(obj):
    """The settings that say so, to be compared."""
    return obj.meanvalue.close_seams, obj.meanvalue.merge_distance


def copies(obj, rest=None, faces=None):
    """As of welding.copies(), in the rest shape; None where each vertex is its own.

    rest, faces: of mesh_arrays, where they are at hand.
    """
    if rest is None:
        rest = shape_keys.rest_positions(obj.data)
    given, faces = signature(obj), faces or kept.faces(obj.data)
    return kept.of(obj.data, "copies", lambda: welding.copies(rest, *given, *faces), rest, *given)
