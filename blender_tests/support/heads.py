# SPDX-License-Identifier: GPL-3.0-or-later
"""A head on a neck, with eyes, pupils in them and buttons on the neck: parts that no handle holds."""

import itertools
import math

import bmesh
import bpy
import numpy as np
from mathutils import Matrix, Vector

from . import handles, meshes, steps

EYES, PUPILS, BUTTONS = "Eyes", "Pupils", "Buttons"


def head(segments=32, live=True):
    """(object, control of the crown, {name of a kind of loose part: [vertex indices of each]}); it looks along -Y."""
    shape = bmesh.new()
    _add_skin(shape, segments)
    parts = {}
    for name, places, radius in (
        (EYES, [(x, -0.87, 0.2) for x in (-0.38, 0.38)], 0.24),
        (PUPILS, [(x, -1.06, 0.2) for x in (-0.38, 0.38)], 0.09),
        (BUTTONS, [(0.0, -0.56, z) for z in (-1.3, -1.7)], 0.1),
    ):
        parts[name] = [_add_ball(shape, place, radius) for place in places]
    mesh = bpy.data.meshes.new("Head")
    shape.to_mesh(mesh)
    shape.free()
    obj = meshes.new_object("Head", mesh)
    meshes.activate(obj)
    loose = {index for each in parts.values() for part in each for index in part}
    heights = {vertex.index: vertex.co.z for vertex in mesh.vertices if vertex.index not in loose}
    steps.add_handle(obj, "Chest", [index for index, height in heights.items() if height < -2.2], pin=True)
    steps.add_handle(obj, "Crown", [index for index, height in heights.items() if height > 0.6], live=live)
    handles.update()
    return obj, bpy.context.object, parts


def _add_skin(shape, segments):
    """A surface of revolution about z: ball, neck and the beginning of a chest."""
    profile = [(math.sin(t), math.cos(t)) for t in np.linspace(0.0, 2.55, 18)[1:]]
    profile += [(0.5, z) for z in np.linspace(-1.0, -2.0, 9)] + [(0.65, -2.2), (0.8, -2.4)]
    rings = []
    for radius, z in profile:
        angles = [2.0 * math.pi * k / segments for k in range(segments)]
        rings.append([shape.verts.new((radius * math.cos(a), radius * math.sin(a), z)) for a in angles])
    top = shape.verts.new((0.0, 0.0, 1.0))
    for k in range(segments):
        shape.faces.new((top, rings[0][k], rings[0][(k + 1) % segments]))
        for upper, lower in itertools.pairwise(rings):
            shape.faces.new((upper[k], lower[k], lower[(k + 1) % segments], upper[(k + 1) % segments]))


def _add_ball(shape, place, radius):
    before = len(shape.verts)
    bmesh.ops.create_icosphere(shape, subdivisions=2, radius=radius, matrix=Matrix.Translation(Vector(place)))
    return list(range(before, len(shape.verts)))
