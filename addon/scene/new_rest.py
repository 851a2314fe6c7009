# SPDX-License-Identifier: GPL-3.0-or-later
"""The pose becomes the rest shape. Hair curves attached to the mesh go along: their points belong to its rest shape, as
Deform Curves on Surface has it."""

import bpy
import numpy as np

from .. import compat, ids, wording
from . import actions, along, key_marks, mesh_arrays, shape_keys, subject
from .core import motion
from .core.motion import unit
from .surface import Surface


def become(obj):
    """The result becomes the reference key, of the mesh and of what goes along. Keys that add to that move along, so
    that they add the same. Returns notes, as sentences. @throws SceneError if there is no result."""
    notes = _become(obj, shape_keys.pose_to_use(obj))
    for other in along.group(obj)[1:]:
        shape = shape_keys.result_positions(other)
        notes += [] if shape is None else _become(other, shape)
    return list(dict.fromkeys(notes))


def _become(obj, shape):
    mesh = obj.data
    reference = mesh.shape_keys.reference_key
    offset = shape - shape_keys.positions(reference)
    follow(obj, shape - offset, shape)
    apart = {reference, shape_keys.result(obj), *key_marks.replacing(obj)}
    carried = [key for key in mesh.shape_keys.key_blocks if adds_to(key, reference, apart)]
    for key in carried:
        shape_keys.write_positions(mesh, key, shape_keys.positions(key) + offset)
    shape_keys.write_positions(mesh, reference, shape)
    store, attribute = compat.position_store(mesh)
    store.foreach_set(attribute, shape.ravel())
    mesh.update()
    driven = [(key, actions.driver_of(key)) for key in carried]
    mixed = {key.name for key, curve in driven if curve and ids.MIX_MARK in curve.driver.variables}
    names = [key.name for key in carried if key.name not in mixed and key_marks.role(key) != key_marks.Role.MIX]
    keys, between = wording.counted(len(names), "shape key"), wording.counted(len(mixed), "in-between key")
    notes = [f"{between} of Bake Mix belong to the rest shape as it was. Press that to make them anew"] if mixed else []
    told = f"{keys} carried along by what they add, and may look different: {wording.quoted(names)}"
    return [*notes, told] if names else notes


def adds_to(key, reference, apart):
    """Whether a key is relative to the reference key, by way of others or not, but not by way of those `apart`."""
    passed = set()
    while key.name not in passed and key not in apart:
        passed.add(key.name)
        key = key.relative_key
    return key == reference and bool(passed)


def follow(obj, rest, posed):
    """Moves the hair of a mesh whose rest shape, n x 3, becomes another, as its triangles at the roots are moved.
    @throws SceneError."""
    hairs = {hair.data: hair for hair in bpy.data.objects if hair.type == 'CURVES' and hair.data.surface == obj}
    hairs = [hair for hair in hairs.values() if hair.data.library is None and len(hair.data.curves)]
    triangles = mesh_arrays.triangles(obj.data, rest) if hairs else ()
    if not len(triangles):
        return
    surfaces = Surface(rest, triangles), Surface(posed, triangles)
    for hair in hairs:
        to_surface = np.linalg.inv(subject.to_world(obj)) @ subject.to_world(hair)
        points = motion.apply(to_surface, mesh_arrays.coordinates(hair.data.position_data, "vector"))
        starts = np.empty(len(hair.data.curve_offset_data), np.int32)
        hair.data.curve_offset_data.foreach_get("value", starts)
        triangle, shares, places, away = surfaces[0].nearest(points[starts[:-1]])
        if away.mean() > surfaces[1].nearest(points[starts[:-1]])[3].mean():
            continue  # it was made on the pose
        before, after = (_frames(obj.data, surface, triangle, shares) for surface in surfaces)
        moved = np.einsum("kc,kcj->kj", shares, surfaces[1].vertices[surfaces[1].triangles[triangle]])
        curve = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
        turned = np.einsum("kij,klj,kl->ki", after[curve], before[curve], points - places[curve])
        shape = motion.apply(np.linalg.inv(to_surface), turned + moved[curve]).astype(np.float32)
        hair.data.position_data.foreach_set("vector", shape.ravel())
        hair.data.update_tag()


def _frames(mesh, surface, triangle, shares):
    """(k, 3, 3): the axes, in columns, at places on a surface, as the node has them where the mesh is smooth."""
    corners, copy = surface.triangles[triangle], mesh.copy()
    store, attribute = compat.position_store(copy)
    store.foreach_set(attribute, surface.vertices.astype(np.float32).ravel())
    copy.update()
    normals = unit(np.einsum("kc,kcj->kj", shares, mesh_arrays.coordinates(copy.vertex_normals, "vector")[corners]))
    bpy.data.meshes.remove(copy)
    across = unit(np.cross(normals, surface.vertices[corners[:, 1]] - surface.vertices[corners[:, 0]]))
    return np.stack([across, np.cross(normals, across), normals], axis=2)
