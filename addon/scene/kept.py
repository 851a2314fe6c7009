# SPDX-License-Identifier: GPL-3.0-or-later
"""What takes long to read of a mesh, or to make of that, kept until the mesh is edited. It is not to be written to.

Blender tells of edits when it evaluates the scene: before each operator, and of our own writing too, which is none.
"""

import contextlib

import bpy
import numpy as np

from .. import compat
from . import mesh_arrays, shape_keys
from .core import welding

_kept = {}  # of the mesh that was asked for last: {its key and counts: {name: (inputs, value)}}
_ours = set()  # keys of the meshes that the add-on is writing to


def of(mesh, name, make, *inputs):
    """What `make()` gives, until the mesh is edited or an input, a number or an array, is another."""
    key = compat.session_key(mesh), len(mesh.vertices), len(mesh.loops), len(mesh.polygons)
    if key not in _kept:
        clear()
        _kept[key] = {}
    found = _kept[key].get(name)
    if found is None or not all(map(np.array_equal, found[0], inputs)):
        _kept[key][name] = found = inputs, make()
    return found[1]


def faces(mesh):
    """As of mesh_arrays.faces()."""
    return of(mesh, "faces", lambda: mesh_arrays.faces(mesh))


def told(mesh):
    """Blender tells that the mesh was written to. Returns whether it may have been edited."""
    key = compat.session_key(mesh)
    if key not in _ours and any(key == of for of, *_counts in _kept):
        clear()
    return key not in _ours


@contextlib.contextmanager
def writing(obj):
    """Inside, the add-on writes to the mesh of `obj`: what is kept stays true. Evaluates the scene before and after."""
    key = compat.session_key(obj.data)
    if key in _ours:
        yield
        return
    bpy.context.view_layer.update()  # of what was done before it tells as of edits
    _ours.add(key)
    try:
        yield
        bpy.context.view_layer.update()
    finally:
        _ours.remove(key)


def has_any():
    return bool(_kept)


def clear():
    _kept.clear()


def seam_settings(obj):
    """The settings that say so, to be compared."""
    return obj.meanvalue.close_seams, obj.meanvalue.merge_distance


def copies(obj, rest=None):
    """As of welding.copies(), in the rest shape, which may be at hand; None where each vertex is its own."""
    rest, given = shape_keys.rest_positions(obj.data) if rest is None else rest, seam_settings(obj)
    return of(obj.data, "copies", lambda: welding.copies(rest, *given, *faces(obj.data)), rest, *given)
