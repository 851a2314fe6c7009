# SPDX-License-Identifier: GPL-3.0-or-later
"""Mesh data as numpy arrays of Blender's own types, float32 and int32: foreach_get copies others number by number."""

import bpy
import numpy as np

from .. import compat


def coordinates(store, name):
    """n x 3 float32 of a (collection, property) as compat has them of meshes and shape keys."""
    found = np.empty(3 * len(store), np.float32)
    store.foreach_get(name, found)
    return found.reshape(-1, 3)


def vertex_positions(mesh):
    """n x 3 float32 of `mesh.vertices`. Shape keys do not show here."""
    return coordinates(*compat.position_store(mesh))


def faces(mesh):
    """(corners, starts): vertex index of every face corner, and where each face begins in it; int32."""
    if len(mesh.loops) == 0:
        return np.empty(0, np.int32), np.empty(0, np.int32)
    return _indices(*compat.corner_store(mesh)), _indices(mesh.polygons, "loop_start")


def _indices(store, name, each=1, own_type=np.uint32):
    """int32: so many of each item of a collection. own_type: Blender's own, to which int32 is another one."""
    found = np.empty(each * len(store), np.int32)
    store.foreach_get(name, found.view(own_type))
    return found


def edges(mesh):
    """m x 2 int32 vertex indices."""
    return _indices(mesh.edges, "vertices", 2).reshape(-1, 2)


def triangles(mesh, rest, corners=None):
    """m x 3 int32: Blender's own triangulation of the shape `rest`, n x 3 float32. corners: of faces(), if at hand.

    How a quad is split depends on where its corners are. The mesh's own triangles are right if its vertices are in
    the rest shape; else a copy in the rest shape is triangulated.
    """
    if len(mesh.loops) == 3 * len(mesh.polygons) or np.array_equal(vertex_positions(mesh), rest):
        return shown_triangles(mesh, corners)
    copy = mesh.copy()
    try:
        copy.vertices.foreach_set("co", rest.ravel())  # by the attribute, 5.2 would keep the triangles of before
        return shown_triangles(copy)
    finally:
        bpy.data.meshes.remove(copy)


def shown_triangles(mesh, corners=None):
    """m x 3 int32: the triangulation of the mesh as it is, face after face. corners: of faces(), if at hand."""
    if len(mesh.loops) == 3 * len(mesh.polygons):
        return (_indices(*compat.corner_store(mesh)) if corners is None else corners).reshape(-1, 3)
    mesh.calc_loop_triangles()
    return _indices(mesh.loop_triangles, "vertices", 3).reshape(-1, 3)
