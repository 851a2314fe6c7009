# SPDX-License-Identifier: GPL-3.0-or-later
"""Which vertices of an object move as one: the one reading of its seams, for all rooms."""

from ..solver.core.fingerprint import digest
from . import mesh_arrays, shape_keys
from .core import welding


def signature(obj):
    """The settings that say so, to be compared."""
    return obj.meanvalue.close_seams, obj.meanvalue.merge_distance


def copies(obj, rest=None, faces=None):
    """As of welding.copies(), in the rest shape; None where each vertex is its own.

    rest, faces: of mesh_arrays, where they are at hand. Without faces, those of the last mesh with as many of each kind
    and the same rest shape are taken, since they take long to read: good enough for what is grabbed.
    """
    mesh = obj.data
    if rest is None:
        rest = shape_keys.rest_positions(mesh)
    if faces is None:
        kept = f"{len(mesh.edges)} {len(mesh.loops)} {len(mesh.polygons)}"
        return welding.copies(rest, *signature(obj), kept, lambda: mesh_arrays.faces(mesh))
    return welding.copies(rest, *signature(obj), digest(*faces), lambda: faces)
