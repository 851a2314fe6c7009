# SPDX-License-Identifier: GPL-3.0-or-later
"""Small mesh objects by class, active and in Object Mode."""

import itertools
import math

import bpy
import numpy as np

from .rings import quads


def make_object(vertices, faces, name="Thing"):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    mesh.update()
    obj = new_object(name, mesh)
    activate(obj)
    return obj


def new_object(name, data=None):
    """An object of the scene, an Empty without data."""
    obj = bpy.data.objects.new(name, data)
    bpy.context.collection.objects.link(obj)
    return obj


def duplicate(obj, linked=False, name=""):
    """A copy with a mesh of its own, or with the same one; what is active stays."""
    copy = obj.copy()
    copy.name = name or copy.name
    if not linked:
        copy.data = obj.data.copy()
    bpy.context.collection.objects.link(copy)
    bpy.context.view_layer.update()
    return copy


def activate(obj):
    bpy.context.view_layer.update()  # without those that were just deleted
    for other in bpy.context.view_layer.objects:
        other.select_set(False)
    obj.select_set(True)  # an object that was just linked is not among the others yet
    bpy.context.view_layer.objects.active = obj


def grid(columns=5, rows=5, name="Grid"):
    """Wavy quads, open; vertex index is row * columns + column."""
    vertices = [
        (column, row, 0.3 * math.sin(1.3 * column + 0.4 * row)) for row in range(rows) for column in range(columns)
    ]
    return make_object(vertices, grid_faces(columns, rows), name)


def textured_grid(columns=5, rows=5):
    """A grid with a UV map, two materials, a smooth face and a crease of its own."""
    obj = grid(columns, rows, "Textured")
    mesh = obj.data
    uv_map = mesh.uv_layers.new(name="Map")
    for loop, uv in zip(mesh.loops, uv_map.data, strict=True):
        uv.uv = (loop.vertex_index * 0.01, 1.0 - loop.vertex_index * 0.02)
    for material_name in ("Skin", "Cloth"):
        mesh.materials.append(bpy.data.materials.new(material_name))
    for polygon in mesh.polygons:
        polygon.material_index = polygon.index % 2
        polygon.use_smooth = polygon.index % 3 == 0
    return obj


def tube(rings=9, segments=8, name="Tube"):
    """A closed tube along z with a 40-degree bulge; vertex index is ring * segments + segment."""
    vertices = []
    for ring in range(rings):
        radius = 1.0 + 0.2 * math.sin(math.pi * ring / (rings - 1))
        for segment in range(segments):
            angle = 2.0 * math.pi * segment / segments
            vertices.append((radius * math.cos(angle), radius * math.sin(angle), 0.6 * ring))
    caps = [tuple(reversed(range(segments))), tuple(range((rings - 1) * segments, rings * segments))]
    return make_object(vertices, [*map(tuple, quads(rings, segments).tolist()), *caps], name)


def two_parts():
    """Two separate 4 x 4 grids in one mesh: vertices 0-15 and 16-31."""
    first = [(column, row, 0.2 * column * row) for row in range(4) for column in range(4)]
    second = [(x + 10.0, y, z) for x, y, z in first]
    faces = grid_faces(4, 4)
    return make_object(first + second, faces + [tuple(16 + i for i in face) for face in faces], "Two Parts")


def split(vertices, faces):
    """(vertices, faces), all faces with corners of their own."""
    ends = np.cumsum([0, *map(len, faces)]).tolist()
    corners = [tuple(vertices[each]) for face in faces for each in face]
    return corners, [tuple(range(*span)) for span in itertools.pairwise(ends)]


def gap(obj):
    """How far vertices that are in one place at rest are seen apart at most."""
    _, first, place = np.unique(
        np.round([tuple(each.co) for each in obj.data.vertices], 3), axis=0, return_index=True, return_inverse=True
    )
    assert len(first) < len(obj.data.vertices)
    found = seen(obj)
    return np.abs(found - found[first[place.ravel()]]).max()


def grid_faces(columns, rows):
    return [
        (low, low + 1, low + columns + 1, low + columns)
        for row in range(rows - 1)
        for low in range(row * columns, row * columns + columns - 1)
    ]


def seen(obj):
    """n x 3 float32: what modifiers and shape keys make of the mesh now, in the object's space."""
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    positions = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", positions)
    return positions.reshape(-1, 3)
