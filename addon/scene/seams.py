# SPDX-License-Identifier: GPL-3.0-or-later
"""Which vertices of an object move as one: the one reading of its seams, for all rooms."""

from ..solver.core.fingerprint import digest
from . import mesh_arrays, shape_keys
from .core import welding

_faces_of = {}  # likeness() of the last mesh: digest of its faces


def signature(obj):
    """The settings that say so, to be compared."""
    return obj.meanvalue.close_seams, obj.meanvalue.merge_distance


def copies(obj, rest=None, faces=None):
    """As of welding.copies(), in the rest shape; None where each vertex is its own.

    rest, faces: of mesh_arrays, where they are at hand. Without faces, those of the last mesh of the same likeness()
    are taken, since they take long to read: good enough for what is grabbed.
    """
    if rest is None:
        rest = shape_keys.rest_positions(obj.data)
    like = likeness(obj, rest)
    if faces is not None or like not in _faces_of:
        faces = faces or mesh_arrays.faces(obj.data)
        _faces_of.clear()
        _faces_of[like] = digest(*faces)
    return welding.copies(rest, *signature(obj), _faces_of[like], lambda: faces or mesh_arrays.faces(obj.data))


def likeness(obj, rest):
    """The same for meshes with the same rest shape, settings of seams, and as many of each kind: quick to get."""
    mesh = obj.data
    return digest(rest, f"{signature(obj)} {len(mesh.edges)} {len(mesh.loops)} {len(mesh.polygons)}")
