# SPDX-License-Identifier: GPL-3.0-or-later
"""The generated head (faces.py) in Blender, with a take of markers on it, and keyed values beside the truth."""

import bpy
import numpy as np

from . import faces, meshes, steps, take_files

PICKED = 4


def make():
    """The head with its shape keys at 0, active."""
    points, polygons = faces.rest()
    obj = meshes.make_object(points.tolist(), polygons, "Face")
    for name, shape in faces.shapes().items():
        steps.add_key(obj, name, shape)
    return obj


def labels(vertices):
    return tuple(f"M{number}" for number in range(len(vertices)))


def captured(path, obj, truth, *, others=None, **damage):
    """Imports a take of `truth` in a space of its own, and chooses it. others: {label: (f, 3)} in the head's space.

    Returns the marked vertices.
    """
    vertices = faces.marked()
    positions = faces.recorded(truth, vertices, **damage)
    names = labels(vertices)
    for name, track in (others or {}).items():
        names, positions = (*names, name), np.concatenate([positions, track[:, None]], axis=1)
    turned = positions @ np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]).T
    placed = (1.1 * turned + [0.4, -0.3, 1.5]).astype(np.float32)
    bpy.context.scene.render.fps, bpy.context.scene.render.fps_base = 30, 1.0
    take = take_files.bring_in(take_files.write_trc(path, names, placed, rate_hz=30.0))
    meshes.activate(obj)
    obj.meanvalue.capture.take = take
    obj.meanvalue.capture.reference_frame = 1.0
    return vertices


def pick(vertices, count=PICKED):
    """The artist picks points of markers that are far from each other."""
    for number in np.linspace(0, len(vertices) - 1, count).astype(int).tolist():
        result = bpy.ops.meanvalue.pick_marker_point(marker=f"M{number}", vertex=int(vertices[number]))
        assert result == {'FINISHED'}


def keyed(obj, frames):
    """(f, 12): what the F-curves of the values say at frames; 0 where there is no curve."""
    keys = obj.data.shape_keys
    curves = take_files.curves(keys)
    found = [curves.find(f'key_blocks["{name}"].value') for name in faces.KEYS]
    return np.array([[curve.evaluate(frame) if curve else 0.0 for curve in found] for frame in frames])
